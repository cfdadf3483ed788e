//! Every constant of the model, with its origin: a probability, a prior, a limit of effort or a formula.
//!
//! | constant | what it is | used by |
//! |---|---|---|
//! | [`NOTHING_MORE`] | the prior probability that the tone is alone | `round` |
//! | [`LOUDER`], [`LOUDER_RANGE`] | the prior that the noise at the tone is louder than the ring's | `leftover` |
//! | [`KEPT_AT`] | the odds at which a cause joins the fit | `round` |
//! | [`UNLIKELY`] | the probability below which a loud residual is not called noise | `mod` |
//! | [`CHANCE`], [`ODD`] | the significance at which a residual is not noise, and at which it is weighed once more | `joint` |
//! | [`PEAK`] | the probability of a noise peak that is tried as a line | `far` |
//! | [`NEAR`] | the distance from which another line is no longer a change of the tone | `round` |
//! | [`ORDERS`] | the fastest change | `envelope` |
//! | [`ROUNDS`], [`LINES`], [`PEAKS`] | limits of effort | `far`, `joint` |

/// Bins on each side of the peak.
pub const REACH: usize = 16;
/// All bins of a window.
pub const WIDTH: usize = 2 * REACH + 1;

/// The prior probability that there is nothing more than the tone: even odds. The causes share the rest equally.
pub const NOTHING_MORE: f32 = 0.5;

/// The prior probability that the noise at the tone is louder than the ring's noise, by a factor of up to [`LOUDER_RANGE`] e-folds of its
/// power, all equally probable.
pub const LOUDER: f32 = 0.1;
/// The largest factor of [`LOUDER`] in e-folds: up to 8,000 times.
pub const LOUDER_RANGE: f32 = 9.0;

/// The odds over `nothing more` at which a cause joins the fit. Noise alone reaches them in less than one block of a hundred (Markov's
/// inequality).
pub const KEPT_AT: f32 = 100.0;

/// The probability of `nothing more` below which a loud residual that no cause explains is not called noise.
pub const UNLIKELY: f32 = 0.05;

/// The significance level of two tests: that the residual is louder than the ring's noise, and that it is louder near the tone than away from
/// it. 1e-6, in standard deviations of a normal distribution.
pub const CHANCE: f32 = 4.753_424;

/// A line nearer to the tone than this, in bins, counts as a change of the tone. Half a bin farther is the first zero of the fifth moment's
/// function, beyond which the moments do not determine a line's distance.
pub const NEAR: f32 = 1.5;

/// A residual beyond this is weighed once more. Noise alone exceeds it in one block of twelve; in standard deviations of a normal
/// distribution.
pub const ODD: f32 = 1.4;

/// The orders of a tone's envelope beside order 0.
pub const ORDERS: usize = 8;
/// All orders of an envelope.
pub const P: usize = ORDERS + 1;

/// The most causes that join the fit.
pub const ROUNDS: u8 = 3;
/// The most lines beside the tone that have columns of their own: a pair in each round.
pub const LINES: usize = 2 * ROUNDS as usize;
/// A peak of the residual is tried as a line if noise as loud as the ring has such a peak in at most a quarter of all windows: the normal
/// deviation with a 33rd of this probability.
pub const PEAK: f32 = 2.427;
/// The peaks of the residual that are tried as lines.
pub const PEAKS: usize = 2;

/// The number of causes.
pub const CAUSES: usize = 5;

/// Within this many bins of an end of a real spectrum the mirror image is as strong as the moments.
pub const EDGE: i32 = 4;

/// A random walk's variances along unit Legendre functions of order 1 and up: `5 / ((2 p - 1) (2 p + 3))`, so that order 1 has 1.
pub const WALK: [f32; ORDERS] = {
    let (mut walk, mut p) = ([0.0; ORDERS], 1);
    while p <= ORDERS {
        // At compile time an index out of range would not compile.
        #[allow(clippy::indexing_slicing)]
        {
            walk[p - 1] = 5.0 / ((2 * p - 1) * (2 * p + 3)) as f32;
        }
        p += 1;
    }
    walk
};

/// `sqrt(2 p + 1)` for order 0 and up: the length of Legendre's functions.
pub const LENGTHS: [f32; P] = [
    1.0,
    1.732_050_8,
    2.236_068,
    2.645_751_2,
    3.0,
    3.316_624_9,
    3.605_551_2,
    3.872_983_5,
    4.123_105_6,
];

/// Multiplication by time takes unit Legendre functions of order p - 1 and p to each other by `p / sqrt(4 p^2 - 1)`: from p = 1 on.
pub const TIME: [f32; ORDERS] = [
    0.577_350_27,
    0.516_397_8,
    0.507_092_55,
    0.503_952_6,
    0.502_518_9,
    0.501_745_3,
    0.501_280_4,
    0.500_979_3,
];

/// Close lines are tried at these distances on each side, a quarter of a bin apart.
pub const DISTANCES: [f32; 6] = [0.25, 0.5, 0.75, 1.0, 1.25, 1.5];

/// The moments of a line at each of [`DISTANCES`], of order 1 and up: `sqrt(2 p + 1) j_p(pi d)`.
pub const CLOSE: [[f32; ORDERS]; 6] = [
    [
        4.260_88e-1,
        8.797_18e-2,
        1.179_504_6e-2,
        1.174_479_8e-3,
        9.311_105_5e-5,
        6.134_829e-6,
        3.458_827_4e-7,
        1.704_434e-8,
    ],
    [
        7.019_737_4e-1,
        3.072_738_6e-1,
        8.500_093e-2,
        1.725_965_2e-2,
        2.773_268_8e-3,
        3.690_022e-4,
        4.191_670_5e-5,
        4.155_164e-6,
    ],
    [
        7.404_069_3e-1,
        5.459_841_5e-1,
        2.399_007_7e-1,
        7.563_313e-2,
        1.865_642_7e-2,
        3.786_202_8e-3,
        6.533_242_4e-4,
        9.810_874e-5,
    ],
    [
        5.513_289e-1,
        6.796_831_5e-1,
        4.377_743e-1,
        1.941_489e-1,
        6.611_828_5e-2,
        1.833_686_2e-2,
        4.297_015e-3,
        8.727_278_3e-4,
    ],
    [
        2.324_594_6e-1,
        6.318_961_4e-1,
        5.968_748_3e-1,
        3.586_288_4e-1,
        1.604_409_2e-1,
        5.754_782_3e-2,
        1.728_338_6e-2,
        4.472_724e-3,
    ],
    [
        -7.799_708e-2,
        4.104_046_8e-1,
        6.343_773_6e-1,
        5.178_899e-1,
        2.982_537e-1,
        1.344_288_1e-1,
        5.006_813_3e-2,
        1.593_902_7e-2,
    ],
];
