/*
 * Picket for C99 and C++: the frequency of a tone in ADC samples, how far it may be off (sigma), and
 * whether it may be used (verdict); from it a velocity, or a range and a velocity.
 *
 *     static picket_real1024 meter;               (the caller's memory: 5.4 KB)
 *     picket_tone tone;
 *     picket_real1024_init_tone(&meter, 48000.0, 0, 4095);
 *     if (picket_real1024_block(&meter, samples, 1024, &tone) == PICKET_OK && tone.verdict == PICKET_GOOD)
 *         printf("%f Hz +- %f Hz\n", tone.frequency_hz, tone.sigma_hz);
 *
 * There is a set of calls for each kind of record and each length: real64, real128, real256, real512, real1024,
 * real2048, real4096, iq64 ... iq4096. PICKET_DECLARE, below, lists those of one.
 *
 * Nothing is allocated and nothing is global: two threads may use two memories at once, and one memory in turn.
 * Every call answers with a picket_status. If it is not PICKET_OK, nothing was written.
 *
 * Licence: MIT OR Apache-2.0.
 */
#ifndef PICKET_H
#define PICKET_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The version of this header; picket_version() is that of the archive. */
#define PICKET_VERSION "0.1.0"
const char *picket_version(void);

/* ---- What a call says ---- */

typedef int32_t picket_status;
enum {
    PICKET_OK = 0,
    PICKET_ERROR_NULL = 1,          /* a pointer is NULL */
    PICKET_ERROR_UNALIGNED = 2,     /* a pointer is not aligned for its type */
    PICKET_ERROR_UNINITIALISED = 3, /* the memory was not initialised for this kind and length */
    PICKET_ERROR_SAMPLES = 4,       /* another number of samples than the call's name says */
    PICKET_ERROR_CODES = 5,         /* fewer than 256 codes, or the low one not first */
    PICKET_ERROR_OPTION = 6,        /* an option without a meaning, or a reserved field that is not 0 */
    PICKET_ERROR_NO_BLOCK = 7,      /* lines before any block, or targets of a frame that is not complete */
    PICKET_ERROR_ROOM = 8,          /* fewer cells or numbers than the frame needs */
    PICKET_ERROR_UNUSABLE = 9,      /* the tone may not be used for a calibration */
    PICKET_ERROR_RATE = 16,         /* the sample rate is not 1e-6 to 1e12 Hz */
    PICKET_ERROR_BAND = 17,         /* the band holds no bin, or its low end is not first */
    PICKET_ERROR_SCENE = 18,        /* a wavelength, bandwidth, duration, angle or curvature out of range */
    PICKET_ERROR_RAMP = 19,         /* a ramp is shorter than its guard and a record */
    PICKET_ERROR_SCALE = 20,        /* range or velocity per cycle out of range */
    PICKET_ERROR_FALSE_ALARM = 21,  /* not above 0, or above 0.5 */
    PICKET_ERROR_FOLLOWING = 22,    /* rate or most out of range */
    PICKET_ERROR_CONFIG = 23,       /* anything else in a configuration */
    PICKET_ERROR_FRAME = 24,        /* not 8, 16, ... 256 sawtooth chirps, or a period below the ramp */
    PICKET_ERROR_LENGTH = 25        /* a record has 64, 128, ... 4096 samples */
};
/* A status in one line of English. Never NULL. */
const char *picket_status_message(picket_status status);

/* ---- Verdicts ---- */

/* made by lab schema: verdicts */
/* What is known against a number. The order of severity is: good, moving, near-edge, clipped, unresolved, image, gap, weak, ambiguous, front-end, no-signal, wrong-codes, coasting. */
enum {
    PICKET_GOOD = 0, /* One steady tone. Sigma is the expected error. */
    PICKET_NEAR_EDGE = 1, /* The tone is so near DC or Nyquist that an offset or its mirror image disturbs it, or it lies outside the band. */
    PICKET_CLIPPED = 2, /* Samples touch the converter's rails: lower the gain. */
    PICKET_UNRESOLVED = 3, /* There is more than one tone in the line: sigma covers only the visible part of the others. */
    PICKET_GAP = 4, /* Samples were lost just before this block. */
    PICKET_WEAK = 5, /* The line is too weak, or too near DC or Nyquist, to be distinguished from noise. */
    PICKET_NO_SIGNAL = 6, /* There is nothing in the band. */
    PICKET_WRONG_CODES = 7, /* Samples lie beyond the stated rails: the converter has other codes. */
    PICKET_MOVING = 8, /* The tone's frequency or level changes within the block: the frequency is the mean over it. */
    PICKET_IMAGE = 9, /* The two channels do not belong together: the frequency may have the wrong sign. */
    PICKET_FRONT_END = 10, /* The lines are those of codes that wrap, or of swapped samples: the tone may be another line. */
    PICKET_AMBIGUOUS = 11, /* The beats fit several targets: a bound of range or velocity, or the next chirp, decides. */
    PICKET_COASTING = 12 /* The block did not measure the tone: this is the track's prediction. */
};
/* end */
/* What a number may be used for. */
enum {
    PICKET_USABLE_YES = 0,
    PICKET_USABLE_WITHIN_SIGMA = 1,
    PICKET_USABLE_WITHOUT_SIGN = 2,
    PICKET_USABLE_ROUGHLY = 3,
    PICKET_USABLE_NO = 4
};
const char *picket_verdict_name(uint8_t verdict);   /* "good", "near-edge"; never NULL */
const char *picket_verdict_reason(uint8_t verdict); /* a sentence; never NULL */
uint8_t picket_verdict_usable(uint8_t verdict);     /* PICKET_USABLE_... */
/* 1 if a verdict is among a tone's `also`, else 0. */
uint8_t picket_verdict_is_among(uint8_t verdict, uint8_t also);

/* ---- What comes out ---- */

/* made by lab schema: structures out */
/* One measured tone. */
typedef struct picket_tone {
    double frequency_hz; /* I/Q: minus to plus half the rate; real: 0 to half the rate */
    double sigma_hz; /* one standard deviation of it */
    float snr; /* signal-to-noise ratio per sample, a power ratio: 10 log10 of it is dB */
    float amplitude; /* ADC codes */
    uint32_t clipped; /* samples of the block that touch a rail */
    uint8_t verdict; /* the most severe that applies */
    uint8_t also; /* the others: picket_verdict_is_among */
    uint8_t reserved[2];
} picket_tone;

/* One of a block's tones, with its phase. */
typedef struct picket_line {
    picket_tone tone; /* the tone */
    float phase_rad; /* at sample N/2: amplitude * cos(phase + 2 pi f (n - N/2) / rate) */
    float sigma_phase_rad; /* one standard deviation of it */
} picket_line;

/* A target that fits the beats of a chirp as others do. */
typedef struct picket_candidate {
    double range_m; /* range */
    double velocity_mps; /* positive when approaching */
    double odds; /* its probability, 0 to 1 */
} picket_candidate;
enum {
    PICKET_CANDIDATES = 4
};

/* A range and a velocity; of a Doppler shift a velocity alone. */
typedef struct picket_target {
    double range_m; /* range */
    double velocity_mps; /* positive when approaching; of real samples the speed; NaN if it is not known */
    picket_candidate candidates[4]; /* the most probable first, if `ambiguity` is PICKET_SEVERAL */
    float sigma_range_m; /* one standard deviation of the range */
    float sigma_velocity_mps; /* one standard deviation of the velocity */
    uint32_t track; /* low bits of the number of the track it comes from; 0 without a tracker */
    uint8_t verdict; /* the most severe that applies */
    uint8_t ambiguity; /* PICKET_UNIQUE, PICKET_SEVERAL, PICKET_COUPLED or what decided */
    uint8_t count; /* of the candidates */
    uint8_t reserved;
} picket_target;
enum {
    PICKET_UNIQUE = 0,
    PICKET_SEVERAL = 1, /* the beats fit several targets: the verdict is PICKET_AMBIGUOUS */
    PICKET_COUPLED = 2, /* a sawtooth: the range of a target at rest, and no velocity */
    PICKET_BY_BOUND = 3, /* the bounds of range and velocity decided */
    PICKET_BY_LAST_CHIRP = 4, /* the chirp before decided */
    PICKET_BY_LEVELS = 5 /* the levels of the lines decided */
};

/* A tone, and what it amounts to. */
typedef struct picket_measurement {
    picket_tone tone; /* the strongest tone of the block */
    picket_target target; /* what it amounts to */
    uint8_t outcome; /* PICKET_OUTCOME_...: what of `target` holds */
    uint8_t reserved[7];
} picket_measurement;
enum {
    PICKET_OUTCOME_NONE = 0, /* a tone; or the chirp is incomplete */
    PICKET_OUTCOME_VELOCITY = 1, /* velocity_mps, sigma_velocity_mps, verdict */
    PICKET_OUTCOME_TARGET = 2 /* all of it */
};

/* A tone that is followed from block to block. */
typedef struct picket_track {
    picket_tone tone; /* as filtered; `clipped` is 0 */
    float rate_hz_per_block; /* rate of its frequency */
    uint32_t number; /* its number, which no other track gets */
    uint32_t age; /* blocks since it was first seen */
    uint8_t state; /* PICKET_TENTATIVE, PICKET_HELD or PICKET_LOST */
    uint8_t misses; /* blocks since it was last seen */
    uint8_t reserved[2];
} picket_track;
enum {
    PICKET_TENTATIVE = 0,
    PICKET_HELD = 1,
    PICKET_LOST = 2
};

/* What a sum of blocks shows. */
typedef struct picket_accumulated {
    picket_tone tone; /* `clipped` is 0 */
    float ln_chance; /* natural logarithm of the probability that noise alone has such a line */
    uint32_t blocks; /* blocks of the sum */
} picket_accumulated;

/* A burst: a tone with an envelope, as of a particle that crosses a beam. */
typedef struct picket_burst {
    picket_tone tone; /* amplitude and snr at the envelope's top; `clipped` is 0 */
    double arrival; /* the middle of the envelope, samples since the stream's first */
    float deviation; /* standard deviation of the Gaussian envelope, samples */
    uint8_t validation; /* PICKET_VALID, or what is known against it */
    uint8_t reserved[3];
} picket_burst;
enum {
    PICKET_VALID = 0, /* one particle; its tone is good */
    PICKET_TWO_PARTICLES = 1, /* more than one at once */
    PICKET_FEW_CYCLES = 2, /* fewer than four between the points at which the power is down by exp(-2) */
    PICKET_SHORT = 3, /* shorter than a thirtieth of a record: take shorter records, or a higher rate */
    PICKET_LONG = 4, /* longer than two fifths of a record: take longer records */
    PICKET_BURST_WEAK = 5, /* noise, or a particle outside of the fringes */
    PICKET_BURST_CLIPPED = 6 /* more than 1 % of its samples touch a rail */
};

/* What was counted in a stream of bursts. */
typedef struct picket_counts {
    uint64_t samples; /* taken */
    uint64_t dead; /* in which no burst could begin */
    uint32_t bursts; /* that a record was cut around, noise that looked like one included */
    uint32_t lost; /* that ended while the record of another was not complete */
    uint32_t longer; /* signals too long for a burst */
    uint32_t reserved;
} picket_counts;

/* A target of a frame of chirps. */
typedef struct picket_frame_target {
    picket_target target; /* in the middle of the frame; its candidates are aliases of the velocity */
    picket_line line; /* its beat in the middle of the frame, as picket_range_by_phase takes it; its verdict is without the aliases */
    float covariance; /* covariance of range and velocity, m^2/s */
    float ln_chance; /* natural logarithm of the probability that noise alone shows such a target */
} picket_frame_target;

/* A range that agrees with a phase. */
typedef struct picket_range_candidate {
    double range_m; /* range */
    double odds; /* its probability, 0 to 1 */
} picket_range_candidate;

/* A range by phase, or by frequency where the phase does not decide. */
typedef struct picket_phase_range {
    double range_m; /* by the phase if `sure`, else by the frequency */
    double velocity_mps; /* positive when approaching; NaN if it is not known */
    double by_frequency_m; /* the range by the frequency alone */
    picket_range_candidate candidates[4]; /* ranges that agree with the phase, the most probable first */
    float sigma_range_m; /* one standard deviation of the range by the noise */
    float uncertainty_range_m; /* one standard deviation of the range by the noise and the calibration */
    float sigma_velocity_mps; /* one standard deviation of the velocity */
    float sigma_by_frequency_m; /* one standard deviation of the range by the frequency alone */
    float sigma_by_phase_m; /* one standard deviation of each candidate by the noise */
    float spacing_m; /* from one candidate to the next: half a wavelength */
    float turn_odds; /* of the most probable candidate against all others together; sure from 10,000 on */
    uint8_t sure; /* 1 if the range is the one by the phase */
    uint8_t verdict; /* the most severe that applies */
    uint8_t count; /* of the candidates */
    uint8_t reserved;
} picket_phase_range;

/* The way of a target by the phase of its tone. */
typedef struct picket_displacement {
    double displacement_m; /* since the start; positive when the target went away */
    float sigma_displacement_m; /* one standard deviation of it */
    uint32_t start; /* the start from which it counts: displacements of different starts do not belong together */
    uint8_t verdict; /* of the tone; unresolved where the whole turns are not sure */
    uint8_t reserved[7];
} picket_displacement;

/* One source's part of an error, as a standard deviation of the answer. */
typedef struct picket_part {
    float range_m; /* of the range */
    float velocity_mps; /* of the velocity */
} picket_part;

/* The parts of an answer's error, and all of it: one standard deviation by the law of JCGM 100. */
typedef struct picket_budget {
    picket_part uncertainty; /* all parts together */
    picket_part noise; /* of the block's noise; a mean over blocks lessens this one alone */
    picket_part clock; /* of the sample clock */
    picket_part carrier; /* of the carrier */
    picket_part slope; /* of the sweep's slope */
    picket_part angle; /* of the angle between beam and motion */
    picket_part range_offset; /* of the range's offset */
    picket_part phase; /* of the phase of a target at 0 m */
} picket_budget;
/* end */
const char *picket_validation_name(uint8_t validation); /* "valid", "two-particles"; never NULL */

/* ---- What goes in ---- */

/* made by lab schema: structures in */
/* What a user sets. Zeros are the library's own choice, except for the rate and the codes. */
typedef struct picket_config {
    double rate_hz; /* samples per second */
    double band_low_hz; /* the band searched; both 0: the whole spectrum */
    double band_high_hz; /* the band searched; both 0: the whole spectrum */
    double false_alarm; /* probability that a block of noise passes for a tone */
    int16_t low_code; /* the converter's rails: 0 and 4095 for 12 bits */
    int16_t high_code; /* the converter's rails: 0 and 4095 for 12 bits */
    uint8_t arithmetic; /* PICKET_ARITHMETIC_... */
    uint8_t reach; /* bins on each side that the fit reads: 4, 8, 16; 0 is 16 */
    uint8_t reserved[2];
} picket_config;
enum {
    PICKET_ARITHMETIC_OF_CORE = 0, /* integers without a floating-point unit, floats with one */
    PICKET_ARITHMETIC_FLOAT = 1, /* not on a core without a floating-point unit */
    PICKET_ARITHMETIC_FIXED = 2 /* not on a core with one, but on a desk */
};

/* What the samples were taken of. */
typedef struct picket_scene {
    double wavelength_m; /* Doppler and chirp */
    double angle_rad; /* Doppler: between beam and motion */
    double bandwidth_hz; /* chirp: how far a ramp rises */
    double duration_s; /* chirp: of each segment */
    double guard_s; /* chirp: from a segment's start to its first sample */
    double sweep_curvature; /* chirp: 0 for straight ramps */
    double range_low_m; /* chirp: what a target may have; both 0: not known */
    double range_high_m; /* chirp: what a target may have; both 0: not known */
    double velocity_low_mps; /* chirp: likewise; positive when approaching */
    double velocity_high_mps; /* chirp: likewise; positive when approaching */
    uint8_t kind; /* PICKET_SCENE_... */
    uint8_t shape; /* chirp: PICKET_TRAPEZOID, PICKET_TRIANGLE or PICKET_SAWTOOTH */
    uint8_t mixing; /* I/Q: PICKET_TX_CONJ_RX or PICKET_RX_CONJ_TX */
    uint8_t reserved[5];
} picket_scene;
enum {
    PICKET_SCENE_TONE = 0,
    PICKET_SCENE_DOPPLER = 1,
    PICKET_SCENE_CHIRP = 2
};
enum {
    PICKET_TRAPEZOID = 0,
    PICKET_TRIANGLE = 1,
    PICKET_SAWTOOTH = 2
};
enum {
    PICKET_TX_CONJ_RX = 0, /* an approaching target's Doppler shift is negative */
    PICKET_RX_CONJ_TX = 1 /* it is positive */
};

/* How tones are followed. */
typedef struct picket_following {
    float rate_bins; /* sigma of a new target's rate, bins per block; 0 is 2 */
    uint8_t most; /* tones followed at once, 1 to 4; 0 is 1 */
    uint8_t refresh; /* one block in `refresh` is searched whole while one tone is locked; 0 searches all */
    uint8_t reserved[2];
} picket_following;

/* What an accumulator adds: the spectra of many blocks without their phases, for echoes too weak for one. */
typedef struct picket_accumulating {
    double false_alarm; /* probability for each sum that noise passes for a tone; 0 is 1e-6 */
    float drift_bins; /* bins by which the line moves from block to block */
    uint32_t blocks; /* of a sum: 1 to 65,536 */
    uint8_t segment; /* of a chirp, whose other blocks are passed over; PICKET_CONTINUOUS adds all */
    uint8_t reserved[7];
} picket_accumulating;

/* When a burst begins and ends. Zeros are the library's own choice. */
typedef struct picket_trigger {
    float ratio; /* energy of an eighth of a record over that of the noise at which it begins; 0: by the noise's scatter */
    uint32_t hold_off; /* samples after a record in which no burst begins */
    uint32_t least; /* the least energy per sample, squared codes, however quiet the noise is */
    uint32_t reserved;
} picket_trigger;

/* A frame of sawtooth chirps. */
typedef struct picket_framing {
    double period_s; /* from one chirp to the next, s */
    double false_alarm; /* probability for each frame that noise alone shows a target; 0 is 1e-6 */
    uint32_t chirps; /* 8, 16, ... 256 */
    int16_t first_bin; /* the bins that are kept of each chirp; both 0: all that have a range */
    int16_t last_bin; /* the bins that are kept of each chirp; both 0: all that have a range */
} picket_framing;

/* What a measurement at a known distance tells of a sensor. Zeros are a perfect sensor. */
typedef struct picket_calibration {
    float phase_rad; /* the phase of a target at 0 m on the rising ramp */
    float sigma_phase_rad; /* one standard deviation of it */
    float offset_m; /* what the frequency shows of a target at 0 m */
    float sigma_offset_m; /* one standard deviation of it */
    float slope_ppm; /* the sweep's true slope over the stated one less 1, parts per million */
    float sigma_slope_ppm; /* one standard deviation of it */
} picket_calibration;

/* What is not known of a sensor, each as one standard deviation. Zeros are known. */
typedef struct picket_uncertainty {
    float clock_ppm; /* of the sample clock, parts per million */
    float carrier_ppm; /* of the carrier, parts per million */
    float slope_ppm; /* of the sweep's slope, parts per million */
    float angle_rad; /* of the angle between beam and motion */
    float range_offset_m; /* of the range's offset */
    float phase_rad; /* of the phase of a target at 0 m: for ranges by phase */
} picket_uncertainty;

/* Where and when a block was taken. */
typedef struct picket_stamp {
    uint64_t clock; /* samples since the start */
    uint32_t sequence; /* the block's number; lost blocks count */
    uint8_t segment; /* PICKET_CONTINUOUS, PICKET_UP, PICKET_FLAT or PICKET_DOWN */
    uint8_t gap; /* 1 if samples are missing before this block */
    uint8_t reserved[2];
} picket_stamp;
enum {
    PICKET_CONTINUOUS = 0,
    PICKET_UP = 1,
    PICKET_FLAT = 2,
    PICKET_DOWN = 3
};
/* end */

/* ---- The calls ---- */

/*
 * Frames of 8 to 256 sawtooth chirps: several targets with range and velocity, also those that no single chirp shows.
 *
 * picket_frame_cells      the cells of 4 bytes that a frame needs: bins that are kept times chirps. `n` is the samples of a chirp's record;
 *                         `iq` is 1 for I/Q records. `scene` is a chirp whose shape is PICKET_SAWTOOTH.
 * picket_frame_init       begins a frame in so many cells, which are its own as long as it is used.
 * KIND_block and KIND_frame_push   take each chirp in turn. A chirp after the last begins a new frame.
 * picket_frame_clear      begins anew, as after a gap.
 * picket_frame_targets    the targets of the complete frame, at most `room` and 8, the strongest first. `still` is what picket_frame_background
 *                         wrote of a frame without targets, or NULL. It takes 20 KB of stack.
 * picket_frame_background what stands still, a pair of floats for each kept bin, and its share of the power; `room` counts pairs.
 */
typedef struct picket_frame {
    uint64_t state[256 / 8];
} picket_frame;
size_t picket_frame_size(void);
picket_status picket_frame_cells(const picket_config *config, const picket_scene *scene, const picket_framing *framing,
                                 size_t n, uint8_t iq, size_t *cells);
picket_status picket_frame_init(picket_frame *frame, const picket_config *config, const picket_scene *scene,
                                const picket_framing *framing, size_t n, uint8_t iq, int16_t (*cells)[2], size_t room);
picket_status picket_frame_clear(picket_frame *frame);
picket_status picket_frame_background(picket_frame *frame, float *still, size_t room, float *share);
picket_status picket_frame_targets(picket_frame *frame, const float *still, picket_frame_target *targets,
                                   size_t room, size_t *found);

/*
 * Ranges by phase, for lines of KIND_lines or of a frame's target. `n`, `iq` and `rate_hz` are those of the records.
 *
 * picket_range_by_phase   the range by the line of one ramp, PICKET_UP or PICKET_DOWN. `target` is its range and velocity by frequency, as of a
 *                         frame; NULL for a target at rest. `calibration` may be NULL: a perfect sensor.
 * picket_range_by_phases  of a triangle or a trapezoid: by the lines of both ramps, also of a target that moves.
 * picket_calibrate        by the rising ramp's line of a target at rest at a known range, with one standard deviation.
 */
picket_status picket_range_by_phase(const picket_scene *scene, const picket_calibration *calibration, double rate_hz,
                                    size_t n, uint8_t iq, uint8_t segment, const picket_line *line,
                                    const picket_target *target, picket_phase_range *answer);
picket_status picket_range_by_phases(const picket_scene *scene, const picket_calibration *calibration, double rate_hz,
                                     size_t n, uint8_t iq, const picket_line *up, const picket_line *down,
                                     const picket_target *target, picket_phase_range *answer);
picket_status picket_calibrate(const picket_scene *scene, double rate_hz, size_t n, uint8_t iq, const picket_line *line,
                               double known_m, float sigma_m, picket_calibration *calibration);

/*
 * The whole error of an answer: the part of each source, and all of them together. `blocks` is 1, or the blocks of a mean, which lessens the
 * noise's part alone. `angle_rad` is the angle for which the velocity was solved.
 */
picket_status picket_budget_of_target(const picket_uncertainty *uncertainty, const picket_target *target,
                                      float angle_rad, uint32_t blocks, picket_budget *budget);
picket_status picket_budget_of_phase_range(const picket_uncertainty *uncertainty, const picket_phase_range *range,
                                           uint32_t blocks, picket_budget *budget);

/*
 * The way of a target by the phase of its line: of a Doppler scene's blocks, or of one record in each sawtooth chirp, whose target turns the phase
 * by less than `most_turns` of a turn from chirp to chirp (0 is 0.25). The stamp's clock and gap count.
 */
typedef struct picket_way {
    uint64_t state[128 / 8];
} picket_way;
size_t picket_way_size(void);
picket_status picket_way_init(picket_way *way, const picket_scene *scene, double rate_hz, size_t n, uint8_t iq, float most_turns);
picket_status picket_way_push(picket_way *way, const picket_stamp *stamp, double rate_hz, const picket_line *line,
                              picket_displacement *answer);

/*
 * `samples` are `count` signed words of 16 bits, or of I/Q `count` pairs of them, I first; `count` must be N.
 * A DMA buffer of uint16_t with codes of up to 15 bits may be cast: (const int16_t *)buffer.
 *
 * KIND_init_tone   the least program memory: one tone anywhere, eight bins on each side, the core's arithmetic.
 * KIND_init        everything of a picket_config; `scene` may be NULL.
 * KIND_block       the strongest tone of a block.
 * KIND_measure     the same, and what it amounts to in the scene. `stamp` may be NULL: the blocks then follow one
 *                  another, and those of a chirp take its segments in turn.
 * KIND_lines       all tones of the last block, at most `room` and 4, the strongest first.
 * KIND_harmonics   the fundamental of the last block's harmonics up to an order from 2 to 32, as of a motor or a string. Bit k of `orders` is set
 *                  if order k + 1 was seen; none is set if nothing stands out.
 * KIND_tracker_... as above; `following` must not be NULL.
 * KIND_track       measures a block, follows its tones, and gives the tracks of its segment, at most 8.
 * KIND_targets     velocities and ranges of the held tracks, at most 4: after the last block of a chirp, or any of a Doppler scene.
 * KIND_accumulate  adds the block that `meter` measured last. If it completes a sum, `*complete` is 1 and `accumulated` is
 *                  written; else `*complete` is 0.
 * KIND_frame_push  takes the chirp that `meter` measured last into a frame, see below; `*complete` is 1 if it is the frame's last.
 * KIND_bursts_...  bursts in a stream; `trigger` may be NULL. KIND_bursts_push takes any number of samples and writes the bursts that
 *                  they complete, at most `room`; `*found` counts those beyond it, too. KIND_bursts_lost declares how many
 *                  samples are missing before the next.
 * KIND_size, KIND_tracker_size, KIND_accumulator_size, KIND_bursts_size   bytes that the archive needs, at most sizeof of the type; any
 *                  memory of that size that is aligned to 8 will do.
 */
#define PICKET_DECLARE(KIND, N, PARTS)                                                                              \
    typedef struct KIND {                                                                                           \
        uint64_t state[(4 * (N) * (PARTS) + 1280) / 8];                                                             \
    } KIND;                                                                                                         \
    typedef struct KIND##_tracker {                                                                                 \
        uint64_t state[(4 * (N) * (PARTS) + 9216) / 8];                                                             \
    } KIND##_tracker;                                                                                               \
    typedef struct KIND##_accumulator {                                                                             \
        uint64_t state[(8 * (N) * (PARTS) + 256) / 8];                                                              \
    } KIND##_accumulator;                                                                                           \
    typedef struct KIND##_bursts {                                                                                  \
        uint64_t state[(10 * (N) * (PARTS) + 2560) / 8];                                                            \
    } KIND##_bursts;                                                                                                \
    size_t KIND##_size(void);                                                                                       \
    picket_status KIND##_init_tone(KIND *memory, double rate_hz, int16_t low_code, int16_t high_code);              \
    picket_status KIND##_init(KIND *memory, const picket_config *config, const picket_scene *scene);                \
    picket_status KIND##_block(KIND *memory, const int16_t *samples, size_t count, picket_tone *tone);              \
    picket_status KIND##_measure(KIND *memory, const picket_stamp *stamp, const int16_t *samples, size_t count,     \
                                 picket_measurement *measurement);                                                  \
    picket_status KIND##_lines(KIND *memory, picket_line *lines, size_t room, size_t *found);                       \
    picket_status KIND##_harmonics(KIND *memory, uint32_t order, picket_tone *fundamental, uint32_t *orders);       \
    size_t KIND##_tracker_size(void);                                                                               \
    picket_status KIND##_tracker_init(KIND##_tracker *memory, const picket_config *config,                          \
                                      const picket_scene *scene, const picket_following *following);                \
    picket_status KIND##_track(KIND##_tracker *memory, const picket_stamp *stamp, const int16_t *samples,           \
                               size_t count, picket_measurement *measurement, picket_track *tracks, size_t room,    \
                               size_t *found);                                                                      \
    picket_status KIND##_targets(KIND##_tracker *memory, picket_target *targets, size_t room, size_t *found);       \
    size_t KIND##_accumulator_size(void);                                                                           \
    picket_status KIND##_accumulator_init(KIND##_accumulator *memory, const picket_accumulating *terms);            \
    picket_status KIND##_accumulate(KIND##_accumulator *memory, const KIND *meter, picket_accumulated *accumulated, \
                                    uint8_t *complete);                                                             \
    picket_status KIND##_frame_push(picket_frame *frame, const KIND *meter, uint8_t *complete);                     \
    size_t KIND##_bursts_size(void);                                                                                \
    picket_status KIND##_bursts_init(KIND##_bursts *memory, const picket_config *config,                            \
                                     const picket_trigger *trigger);                                                \
    picket_status KIND##_bursts_push(KIND##_bursts *memory, const int16_t *samples, size_t count,                   \
                                     picket_burst *bursts, size_t room, size_t *found);                             \
    picket_status KIND##_bursts_lost(KIND##_bursts *memory, uint64_t samples);                                      \
    picket_status KIND##_bursts_counts(KIND##_bursts *memory, picket_counts *counts);

/* X(KIND, N, parts of a sample) for every kind and length. */
#define PICKET_EACH(X)          \
    X(picket_real64, 64, 1)     \
    X(picket_real128, 128, 1)   \
    X(picket_real256, 256, 1)   \
    X(picket_real512, 512, 1)   \
    X(picket_real1024, 1024, 1) \
    X(picket_real2048, 2048, 1) \
    X(picket_real4096, 4096, 1) \
    X(picket_iq64, 64, 2)       \
    X(picket_iq128, 128, 2)     \
    X(picket_iq256, 256, 2)     \
    X(picket_iq512, 512, 2)     \
    X(picket_iq1024, 1024, 2)   \
    X(picket_iq2048, 2048, 2)   \
    X(picket_iq4096, 4096, 2)
PICKET_EACH(PICKET_DECLARE)

#ifdef __cplusplus
}
#endif
#endif
