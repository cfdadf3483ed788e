//! The lidar paper's Table 1: the cost of each method.

use super::count::{Cost, Counted, cost_of};
use super::lab::{Check, Lab, Section, Table};
use super::lidar::{N, transform};
use crate::simulate::{Line, Signal, generator};
use picket_dsp::acquire::sample::{Iq, Real};
use picket_dsp::methods::registry::Method;
use picket_dsp::spectrum::bins::{Bins, Rectangular};
use picket_transform::num_complex::Complex;

/// The cost of a method on a record of its kind, beyond the FFT.
fn cost(method: Method, iq: bool) -> Cost {
    let mut signal = Signal::tone(64.2, 1000.0, 20.0);
    signal.lines = vec![Line { bins: 64.2, amplitude: 1000.0, phase: Some(0.5) }];
    let counted = |x: Complex<f64>| Complex::new(Counted(x.re), Counted(x.im));
    let one = |record: Vec<Complex<f64>>| {
        let spectrum: Vec<_> = transform(&record).into_iter().map(counted).collect();
        let samples: Vec<_> = record.into_iter().map(counted).collect();
        (spectrum, samples)
    };
    if iq {
        let (spectrum, samples) = one(signal.record::<Iq>(N, &mut generator(7, 0)));
        let bins = Bins::<Counted, Iq, Rectangular>::gather(N, 64, |k| spectrum[k]);
        let power = |k: i32| spectrum[k as usize].norm_sqr();
        cost_of(|| {
            let _ = method.offset(&bins, samples.as_slice(), power);
        })
    } else {
        let (spectrum, samples) = one(signal.record::<Real>(N, &mut generator(7, 0)));
        let samples: Vec<Counted> = samples.into_iter().map(|x| x.re).collect();
        let bins = Bins::<Counted, Real, Rectangular>::gather(N, 64, |k| spectrum[k]);
        let power = |k: i32| spectrum[k as usize].norm_sqr();
        cost_of(|| {
            let _ = method.offset(&bins, samples.as_slice(), power);
        })
    }
}

/// Table 1: operations beyond the FFT.
pub fn operations(_: &Lab) -> Result<Section, String> {
    let mut table =
        Table::new(["method", "additions", "multiplications", "divisions", "roots", "functions"]);
    for &method in Method::ALL {
        let cost = cost(method, method.fits::<Iq>());
        let Cost { additions, multiplications, divisions, roots, functions } = cost;
        let counts = [additions, multiplications, divisions, roots, functions];
        table.row([method.name().to_owned()].into_iter().chain(counts.map(|c| c.to_string())));
    }
    let multiplications = |method| cost(method, true).multiplications as f64;
    let rife = multiplications(Method::Rife);
    let stages = N.ilog2();
    let fft = 2 * N * stages as usize;
    Ok(Section {
        title: "Lidar paper, Table 1: what each method costs",
        text: vec![format!(
            "Counted by running every method once on a number that counts, N = {N}, beyond an FFT of {fft} real \
             multiplications. The paper says that Z-Rife takes two multiplications and two additions more than Rife, whose \
             magnitudes it has at hand. Counted from the bins on, Rife needs both neighbours' powers and Z-Rife one and a complex \
             product, of which the compiler drops the half that nobody reads: it takes no more than Rife. Least squares is \
             the registry's, 33 bins."
        )],
        tables: vec![table],
        checks: vec![
            Check::between(
                "multiplications of Z-Rife beyond Rife's",
                multiplications(Method::ZRife) - rife,
                0.0,
                0.0,
                2.0,
            ),
            Check::between(
                "multiplications of FESA / N",
                multiplications(Method::Fesa) / N as f64,
                0.0,
                4.0,
                7.0,
            ),
            Check::between(
                "multiplications of least squares over the FFT's",
                multiplications(Method::LeastSquares) / fft as f64,
                0.0,
                0.0,
                // A twentieth for the fit, and a quarter of that for the tests of what it leaves.
                0.065,
            ),
        ],
        ..Section::default()
    })
}
