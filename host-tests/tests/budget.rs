//! The budget of instructions and memory, and the kernels against their definition, on emulated cores.

use host_tests::{prepare_images, prepare_packages};
use picket_dsp::Effort;
use picket_dsp::acquire::sample::{Iq, Real, Record};
use picket_host::toolchain::{Profile, Target};
use picket_lab::bench::model::Model;
use picket_lab::bench::{
    self, CORES, Core, Count, ENGINES, Engine, How, Scope,
    equality::{self, Equality},
    locked, ranging, several, size,
    worst::{self, Worst},
};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A figure may exceed its budget by so much: what another compiler of the same language does to code that is not assembly.
const MARGIN: f64 = 0.01;

/// `budget.json`: what may be spent, on the Cortex-M4F where nothing else is said.
#[derive(Deserialize)]
struct Budgets {
    engines: BTreeMap<String, Budget>,
    /// Instructions of a block that is measured where its tone is expected, on the average, by stage.
    locked: BTreeMap<String, u64>,
    /// Instructions of all tones of blocks of one to four, beside the measurement: the mean.
    several: Vec<u64>,
    /// Instructions of the phase of a block's only tone.
    phase: u64,
    /// Instructions of ranges by phase, of the whole error and of a clock beside another, by core and stage.
    ranging: BTreeMap<String, BTreeMap<String, u64>>,
    /// Instructions and modelled cycles that no measurement takes more of, by core, kind of record, length and effort; 0 where no cycles are
    /// modelled.
    ceilings: BTreeMap<String, BTreeMap<String, Ceilings>>,
    /// Instructions of the search for the peak in so many bins of 1,024 samples, real and I/Q.
    band: BTreeMap<u32, [u64; 2]>,
    /// Instructions for 1,024 samples on cores without the DSP extension, by core and stage: the median.
    portable: BTreeMap<String, BTreeMap<String, u64>>,
    /// The most on such cores: of records without a sample at a rail, and of those with.
    portable_worst: BTreeMap<String, BTreeMap<String, [u64; 2]>>,
    /// Modelled cycles on such cores, by core and stage: the median of a part of the records.
    portable_cycles: BTreeMap<String, BTreeMap<String, u64>>,
    /// Instructions on the Cortex-M55, by record length and stage: the median, and the most of records without a sample at
    /// a rail and of those with.
    helium: BTreeMap<usize, BTreeMap<String, [u64; 3]>>,
    /// Bytes of program memory of the image that measures one tone, for size and for speed, and of the image without verdicts, for size, by
    /// core: start-up, code and tables.
    single_images: BTreeMap<String, [u64; 3]>,
}

/// Instructions and modelled cycles by length and effort.
type Ceilings = BTreeMap<usize, BTreeMap<String, [u64; 2]>>;

/// What an engine may spend.
#[derive(Deserialize)]
struct Budget {
    /// Instructions of each stage, by record length: the median of the records.
    instructions: BTreeMap<usize, BTreeMap<String, u64>>,
    /// The most, by record length and stage: of records without a sample at a rail, and of those with.
    worst: BTreeMap<usize, BTreeMap<String, [u64; 2]>>,
    /// Modelled cycles of each stage, by record length: the median of a part of the records.
    #[serde(default)]
    cycles: BTreeMap<usize, BTreeMap<String, u64>>,
    /// Bytes of the pipeline with two records, by record length.
    ram_bytes: BTreeMap<usize, u64>,
    /// The least ratio to the error of the transform in dB, full scale and 40 dB below.
    snr_db: BTreeMap<usize, [f64; 2]>,
}

fn budgets() -> Budgets {
    serde_json::from_str(include_str!("../budget.json")).unwrap()
}

fn core(name: &str) -> &'static Core {
    CORES.iter().find(|core| core.name == name).unwrap()
}

fn count(core: &Core, engine: &Engine, image: &Path, n: usize, random: u32) -> Count {
    // What every block takes; the joint fit has its ceilings, below.
    let how = How { effort: Effort::LOOK, ..How::default() };
    let count = bench::count(core, engine, image, n, how, random);
    count.unwrap_or_else(|error| panic!("{}, N = {n}: {error}", core.name))
}

fn image(core: &Core, engine: &Engine, scope: Scope) -> PathBuf {
    prepare_images(core.target);
    bench::image(core, engine, scope).unwrap_or_else(|error| panic!("{error}"))
}

/// All that exceeds its budget, so that one run tells everything.
#[derive(Default)]
struct Excess(Vec<String>);

impl Excess {
    fn check(&mut self, what: &str, spent: u64, allowed: u64) {
        let share = spent as f64 / allowed as f64 - 1.0;
        println!("{what}: {spent} of {allowed} ({:+.2} %)", 100.0 * share);
        if share > MARGIN {
            self.0.push(format!("{what}: {spent} of {allowed}"));
        }
        if share < -MARGIN {
            println!("  that is less: lower the budget");
        }
    }
}

fn assert_kept(engines: &[Engine]) {
    let (budgets, core, mut excess) = (budgets(), core("M4F"), Excess::default());
    for engine in engines {
        excess.check_engine(core, engine, &budgets.engines[engine.name]);
    }
    assert!(excess.0.is_empty(), "over the budget: {:#?}", excess.0);
}

#[test]
fn the_budget_is_kept() {
    assert_kept(&ENGINES[..1]);
}

#[test]
#[ignore = "needs images of the float engine: cargo test --test all -- --ignored"]
fn the_budget_is_kept_by_the_float_engine() {
    assert_kept(&ENGINES[1..]);
}

impl Excess {
    /// Nothing that was found is above the ceilings of instructions and cycles, and the worst has this share of them.
    fn check_ceiling(&mut self, what: &str, found: &[Worst], ceilings: [u64; 2], share: f64) {
        for Worst { instructions, signal, .. } in found {
            println!("{what}: {instructions} instructions by {signal}");
        }
        let instructions = found.iter().map(|worst| worst.instructions).max();
        let cycles = found.iter().filter_map(|worst| worst.cycles).max();
        let kinds = ["instructions", "modelled cycles"].into_iter().zip([instructions, cycles]);
        for ((kind, most), ceiling) in kinds.zip(ceilings) {
            // No cycles are modelled of a core whose timing is not published.
            let Some(most) = most.filter(|_| ceiling > 0) else { continue };
            println!("{what}: {most} {kind} of {ceiling}");
            if most > ceiling {
                self.0.push(format!("{what}: {most} {kind} of {ceiling}"));
            }
            assert!(most as f64 > share * ceiling as f64, "{what}: {most} {kind} of {ceiling}");
        }
    }

    fn check_single_images(&mut self, core: &Core, allowed: [u64; 3]) {
        use Profile::{Release, Size};
        for ((bin, profile), allowed) in
            [("single", Size), ("single", Release), ("frequency_only", Size)]
                .into_iter()
                .zip(allowed)
        {
            let spent = size::program_memory(core, bin, profile);
            let spent = spent.unwrap_or_else(|error| panic!("{error}"));
            let name = format!("{}, bytes of the image {bin} for {}", core.name, profile.name());
            self.check(&name, spent, allowed);
        }
    }

    fn check_stages(&mut self, name: &str, count: &Count, stages: &BTreeMap<String, u64>) {
        for (stage, &allowed) in stages {
            let spent = count.median(stage).unwrap();
            self.check(&format!("{name}, {stage}, instructions"), spent, allowed);
        }
    }

    fn check_cycles(
        &mut self,
        name: &str,
        (core, image, n): (&Core, &Path, usize),
        stages: &BTreeMap<String, u64>,
    ) {
        let model = Model::of(core, image, n, How::default());
        let model = model.unwrap_or_else(|error| panic!("{name}: {error}")).unwrap();
        for (stage, &allowed) in stages {
            let spent = model.median(stage).unwrap();
            self.check(&format!("{name}, {stage}, modelled cycles"), spent, allowed);
        }
    }

    fn check_worst(&mut self, name: &str, count: &Count, stages: &BTreeMap<String, [u64; 2]>) {
        for (stage, allowed) in stages {
            for (clipped, &allowed) in [false, true].into_iter().zip(allowed) {
                let spent = count.worst(stage, clipped).unwrap();
                let kind = if clipped { "clipped" } else { "unclipped" };
                self.check(&format!("{name}, {stage}, worst {kind}, instructions"), spent, allowed);
            }
        }
    }

    fn check_helium(
        &mut self,
        name: &str,
        count: &Count,
        budget: Option<&BTreeMap<String, [u64; 3]>>,
        stages: &[&str],
    ) {
        for (stage, allowed) in budget.into_iter().flatten() {
            if stages.contains(&stage.as_str()) {
                let stage = stage.as_str();
                let spent =
                    [count.median(stage), count.worst(stage, false), count.worst(stage, true)];
                for (kind, (spent, allowed)) in ["median", "worst unclipped", "worst clipped"]
                    .iter()
                    .zip(spent.iter().zip(allowed))
                {
                    self.check(
                        &format!("{name}, {stage}, {kind}, instructions"),
                        spent.unwrap(),
                        *allowed,
                    );
                }
            }
        }
    }

    fn check_engine(&mut self, core: &Core, engine: &Engine, budget: &Budget) {
        let image = image(core, engine, Scope::Ours);
        for (&n, stages) in &budget.instructions {
            let (name, count) =
                (format!("{}, N = {n}", engine.name), count(core, engine, &image, n, 0));
            assert_second_step(&name, &count);
            self.check_stages(&name, &count, stages);
            self.check_worst(&name, &count, &budget.worst[&n]);
            if let Some(stages) = budget.cycles.get(&n) {
                self.check_cycles(&name, (core, &image, n), stages);
            }
            let ram = count.pipeline_bytes().unwrap();
            self.check(&format!("{name}, bytes of RAM"), ram, budget.ram_bytes[&n]);
            let (reached, least) = (count.snr_db().unwrap(), budget.snr_db[&n]);
            println!("{name}, signal to error: {reached:.2?} dB");
            if reached[0] < least[0] || reached[1] < least[1] {
                self.0.push(format!("{name}, signal to error: {reached:.2?} of {least:.2?} dB"));
            }
        }
    }
}

/// What a block may take at most, by what a search over signals of every kind finds: nothing above the ceiling, and something not far below it, or
/// the ceiling or the search is wrong. `PICKET_LONG=1` makes it a long one; `PICKET_SEED` is its seed.
fn assert_no_worse_block(target: Target) {
    let (budgets, mut excess) = (budgets(), Excess::default());
    let seed = std::env::var("PICKET_SEED").ok().map(|text| text.parse().unwrap());
    let (seed, long) = (seed.unwrap_or(worst::SEED), std::env::var_os("PICKET_LONG").is_some());
    for (name, kinds) in &budgets.ceilings {
        let core = core(name);
        if core.target != target {
            continue;
        }
        let scope = if core.target == Target::M4f { Scope::Ours } else { Scope::Short };
        let image = image(core, &ENGINES[0], scope);
        for (kind, lengths) in kinds {
            for (&n, efforts) in lengths {
                for (effort, ceilings) in efforts {
                    let effort = Effort::from_name(effort).unwrap();
                    let what = format!("{name}, {kind}, N = {n}, {}", effort.name());
                    let generations = if long { 60 } else { 4 };
                    let how = How { effort, ..How::default() };
                    let found = if kind == "iq" {
                        worst::search::<Iq>(core, &image, n, how, seed, generations)
                    } else {
                        worst::search::<Real>(core, &image, n, how, seed, generations)
                    };
                    let found = found.unwrap_or_else(|error| panic!("{what}: {error}"));
                    let found: Vec<Worst> = found.into_iter().flatten().collect();
                    excess.check_ceiling(&what, &found, *ceilings, if long { 0.85 } else { 0.55 });
                }
            }
        }
    }
    assert!(excess.0.is_empty(), "over the budget: {:#?}", excess.0);
}

#[test]
fn a_search_finds_no_worse_block() {
    assert_no_worse_block(Target::M4f);
}

#[test]
#[ignore = "needs images of the Cortex-M3: cargo test --test all -- --ignored"]
fn a_search_finds_no_worse_block_on_cortex_m3() {
    assert_no_worse_block(Target::M3);
}

#[test]
#[ignore = "needs images of the Cortex-M0: cargo test --test all -- --ignored"]
fn a_search_finds_no_worse_block_on_cortex_m0() {
    assert_no_worse_block(Target::M0);
}

#[test]
#[ignore = "needs images of the Cortex-M55: cargo test --test all -- --ignored"]
fn a_search_finds_no_worse_block_on_cortex_m55() {
    assert_no_worse_block(Target::M55);
}

/// A band costs in proportion to its width, and one without the lowest bins what the whole spectrum costs.
#[test]
fn the_budget_is_kept_in_a_band() {
    let (budgets, core, mut excess) = (budgets(), core("M4F"), Excess::default());
    let image = image(core, &ENGINES[0], Scope::Ours);
    for (&width, &[real, iq]) in &budgets.band {
        // The tone is at bin 101.
        let bins = 90..=89 + width;
        let spent = bench::in_band::<Real>(core, &image, 1024, bins.clone(), "peak").unwrap();
        excess.check(&format!("{width} bins of N = 1024, search, instructions"), spent, real);
        let spent = bench::in_band::<Iq>(core, &image, 1024, bins, "peak").unwrap();
        excess.check(&format!("{width} bins of N = 1024, I/Q, search, instructions"), spent, iq);
    }
    for n in bench::LENGTHS {
        let n_bins = n as u32;
        let last = n_bins / 2 - 1;
        let count = |bins, stage| bench::in_band::<Real>(core, &image, n, bins, stage).unwrap();
        let [whole, all] = ["peak", "measurement"].map(|stage| count(1..=last, stage));
        println!("N = {n}: {whole} instructions for all bins, {all} for the measurement");
        for (name, bins) in [
            ("without the lowest", 2..=last),
            ("the lower half", 1..=n_bins / 4 - 1),
            ("a sixteenth", n_bins / 16..=n_bins / 8 - 1),
        ] {
            let [search, measurement] =
                ["peak", "measurement"].map(|stage| count(bins.clone(), stage));
            println!("N = {n}: {search}, {measurement} for {name}");
            // One bin is split by itself.
            if name == "without the lowest" {
                assert!(search < whole + 150, "N = {n}: {search}, {whole}");
            }
        }
    }
    assert!(excess.0.is_empty(), "over the budget: {:#?}", excess.0);
}

/// Some records take a second step and others do not.
fn assert_second_step(name: &str, count: &Count) {
    let mut each: Vec<u64> = count.each("estimator", false).collect();
    each.sort_unstable();
    println!("{name}, estimator, record by record: {each:?}");
    // A step over 33 bins takes no less.
    let (few, most) = (each[each.len() / 4], each[each.len() - 1]);
    assert!(most > few + 350, "{name}: {each:?}");
}

fn assert_kept_without_the_dsp_extension(target: Target) {
    let (budgets, mut excess) = (budgets(), Excess::default());
    for (name, stages) in &budgets.portable {
        let (core, engine) = (core(name), &ENGINES[0]);
        if core.target != target {
            continue;
        }
        // Random blocks, because the M0 has kernels of its own.
        let image = image(core, engine, Scope::Short);
        let count = count(core, engine, &image, 1024, 200);
        let (compared, unequal) = count.equality();
        assert!(compared > 200 && unequal == 0, "{name}: {unequal} of {compared} blocks differ");
        assert_second_step(name, &count);
        excess.check_stages(name, &count, stages);
        excess.check_worst(name, &count, &budgets.portable_worst[name]);
        excess.check_cycles(name, (core, &image, 1024), &budgets.portable_cycles[name]);
    }
    assert!(excess.0.is_empty(), "over the budget: {:#?}", excess.0);
}

#[test]
#[ignore = "needs images of the Cortex-M3: cargo test --test all -- --ignored"]
fn the_budget_is_kept_without_the_dsp_extension_on_cortex_m3() {
    assert_kept_without_the_dsp_extension(Target::M3);
}

#[test]
#[ignore = "needs images of the Cortex-M0: cargo test --test all -- --ignored"]
fn the_budget_is_kept_without_the_dsp_extension_on_cortex_m0() {
    assert_kept_without_the_dsp_extension(Target::M0);
}

#[test]
fn the_smallest_images_keep_their_sizes() {
    let (budgets, mut excess) = (budgets(), Excess::default());
    prepare_packages();
    for (name, &allowed) in &budgets.single_images {
        excess.check_single_images(core(name), allowed);
    }
    assert!(excess.0.is_empty(), "over the budget: {:#?}", excess.0);
}

/// Random blocks and periodic ones, of every width and strength, at the rails and between; as many more as the variable
/// `PICKET_RANDOM_BLOCKS` says, for each length.
fn assert_kernels(cores: &[&str], engines: &[Engine]) {
    let random: Option<u32> =
        std::env::var("PICKET_RANDOM_BLOCKS").ok().map(|text| text.parse().unwrap());
    let own = || engines.iter().filter(|engine| engine.is_own());
    for (core, engine) in cores.iter().flat_map(|name| own().map(|e| (core(name), e))) {
        let image = image(core, engine, Scope::Ours);
        for n in bench::LENGTHS {
            let blocks = random.unwrap_or(60_000 / n as u32);
            let (compared, unequal) = count(core, engine, &image, n, blocks).equality();
            let name = format!("{}, {}, N = {n}", core.name, engine.name);
            println!("{name}: {compared} blocks, {unequal} differ");
            assert!(compared > u64::from(blocks) && unequal == 0, "{name}");
            assert_equal::<Iq>(&format!("{name}, I/Q"), core, &image, n, blocks.div_ceil(4));
        }
    }
}

/// The M7 runs the M4F's image.
#[test]
fn the_kernels_equal_their_definition() {
    assert_kernels(&["M4F", "M7"], &ENGINES[..1]);
}

#[test]
#[ignore = "needs images of every length for the Cortex-M33: cargo test --test all -- --ignored"]
fn the_kernels_equal_their_definition_on_cortex_m33() {
    assert_kernels(&["M33"], &ENGINES);
}

#[test]
#[ignore = "needs images of every length for the Cortex-M0: cargo test --test all -- --ignored"]
fn the_kernels_equal_their_definition_on_cortex_m0() {
    assert_kernels(&["M0"], &ENGINES);
}

/// Drives kernels and definition with random blocks, of the seed that `PICKET_SEED` says.
fn assert_equal<R: Record>(
    name: &str,
    core: &Core,
    image: &Path,
    n: usize,
    blocks: u32,
) -> Equality {
    let seed = std::env::var("PICKET_SEED").ok().map(|text| text.parse().unwrap());
    let (seed, start) = (seed.unwrap_or(equality::SEED), Instant::now());
    let equality = equality::compare::<R>(core, image, n, blocks, seed);
    let equality = equality.unwrap_or_else(|error| panic!("{name}: {error}"));
    println!("{name}, seed {seed}: {equality}, {:.1} s", start.elapsed().as_secs_f64());
    assert!(equality.holds(blocks), "{name}, seed {seed}: {equality}");
    equality
}

/// The kernels of the Cortex-M55: their bits, and what they take.
#[test]
#[ignore = "needs images of the Cortex-M55: cargo test --test all -- --ignored"]
fn the_kernels_of_helium_equal_their_definition_and_keep_their_budget() {
    let (budgets, core, engine, mut excess) =
        (budgets(), core("M55"), &ENGINES[0], Excess::default());
    let long = std::env::var_os("PICKET_LONG").map(|_| 100_000);
    let random = std::env::var("PICKET_RANDOM_BLOCKS").ok().map(|text| text.parse().unwrap());
    let kernels = image(core, engine, Scope::Kernels);
    for n in bench::LENGTHS {
        let blocks: u32 = random.or(long).unwrap_or(60_000 / n as u32);
        let name = format!("M55, N = {n}");
        let equality = assert_equal::<Real>(&name, core, &kernels, n, blocks);
        assert!(n != 1024 || equality.interrupts > Some(4_000), "{equality}");
        assert_equal::<Iq>(&format!("{name}, I/Q"), core, &kernels, n, blocks);
        let count = count(core, engine, &kernels, n, 0);
        let (compared, unequal) = count.equality();
        assert!(compared > 200 && unequal == 0, "{name}: {unequal} of {compared} blocks differ");
        excess.check_helium(&name, &count, budgets.helium.get(&n), &["fft", "peak", "fft_peak"]);
    }
    // The image that counts a whole measurement is built for the long run alone.
    if random.or(long).is_some() {
        let short = image(core, engine, Scope::Short);
        let count = count(core, engine, &short, 1024, 200);
        excess.check_helium("M55, N = 1024", &count, budgets.helium.get(&1024), &bench::STAGES);
    }
    assert!(excess.0.is_empty(), "over the budget: {:#?}", excess.0);
}

/// A tone of 60 to -5 dB that is followed: what a block costs, the kernels against their definition, and the same records and tracks
/// on every core as here.
fn assert_locked(cores: &[&str]) {
    let random: Option<u32> =
        std::env::var("PICKET_RANDOM_BLOCKS").ok().map(|text| text.parse().unwrap());
    let (budgets, mut excess) = (budgets(), Excess::default());
    let (here, held) = locked::here().unwrap();
    // One of 16 blocks is searched, and the first two, and one where the noise rises by 20 dB and more.
    assert!(held >= 115, "{held}");
    for core in cores.iter().map(|name| core(name)) {
        prepare_images(core.target);
        let image = locked::image(core).unwrap_or_else(|error| panic!("{error}"));
        let count = locked::count(core, &image, random.unwrap_or(100) / 10)
            .unwrap_or_else(|error| panic!("{}: {error}", core.name));
        assert!(count.telemetry == here, "{}: other bits than here", core.name);
        let (compared, unequal) = count.equality;
        println!("{}: {compared} blocks, {unequal} differ", core.name);
        assert!(compared > 100 && unequal == 0, "{}", core.name);
        if core.name != "M4F" {
            continue;
        }
        for (stage, &allowed) in &budgets.locked {
            let row = count.stage(stage).unwrap();
            println!("{stage}: at most {}", row.most);
            excess.check(&format!("{stage}, instructions"), row.mean, allowed);
        }
        let [short, whole] = ["lock", "whole"].map(|name| count.stage(name).unwrap().mean);
        // The mixing, the transform, the fit and the checks of what they found: eight times cheaper than the whole way
        // less the search for clipped samples, which both make.
        assert!(short <= 4500 && 7 * short < whole - budgets.locked["clipped"], "{short}, {whole}");
    }
    assert!(excess.0.is_empty(), "over the budget: {:#?}", excess.0);
}

#[test]
fn a_locked_block_keeps_its_budget_and_its_bits() {
    assert_locked(&["M4F", "M7"]);
}

#[test]
#[ignore = "needs images of the Cortex-M3: cargo test --test all -- --ignored"]
fn a_locked_block_keeps_its_bits_on_cortex_m3() {
    assert_locked(&["M3"]);
}

#[test]
#[ignore = "needs an image for the Cortex-M33: cargo test --test all -- --ignored"]
fn a_locked_block_keeps_its_bits_on_cortex_m33() {
    assert_locked(&["M33"]);
}

/// Blocks of one to four tones are found as many as there are.
#[test]
fn further_tones_are_counted() {
    assert_counted();
}

fn assert_counted() -> Vec<u8> {
    let (here, found) = several::here().unwrap();
    let right: Vec<_> = (0..found.len()).map(|block| 1 + 4 * block / found.len()).collect();
    assert_eq!(found, right);
    here
}

/// The same tones on an emulated core as here.
#[test]
#[ignore = "needs an image of several tones: cargo test --test all -- --ignored"]
fn further_tones_have_the_same_bits() {
    let here = assert_counted();
    let core = core("M4F");
    prepare_images(core.target);
    let image = several::image(core).unwrap_or_else(|error| panic!("{error}"));
    let (rows, sent) = several::count(core, &image).unwrap_or_else(|error| panic!("{error}"));
    assert!(sent == here, "other bits than here");
    let (budgets, mut excess) = (budgets(), Excess::default());
    assert_eq!(rows.len(), budgets.several.len());
    for (row, &allowed) in rows.iter().zip(&budgets.several) {
        excess.check(&format!("{} tones, instructions", row.tones), row.lines, allowed);
    }
    excess.check("phase of one tone, instructions", rows[0].phase, budgets.phase);
    assert!(excess.0.is_empty(), "over the budget: {:#?}", excess.0);
}

/// Frames of chirps, ranges by phase, the whole error, a clock beside another.
fn assert_ranging(name: &str) {
    let core = core(name);
    prepare_images(core.target);
    let image = ranging::image(core).unwrap_or_else(|error| panic!("{error}"));
    let counted = ranging::count(core, &image).unwrap_or_else(|error| panic!("{error}"));
    println!("{name}: {counted:?}");
    let (budgets, mut excess) = (budgets(), Excess::default());
    for (stage, &allowed) in &budgets.ranging[name] {
        let spent = *counted.get(stage).unwrap_or_else(|| panic!("{stage} is not counted"));
        excess.check(&format!("{name}, {stage}, instructions"), spent, allowed);
    }
    assert!(excess.0.is_empty(), "over the budget: {:#?}", excess.0);
}

#[test]
#[ignore = "needs an image of frames: cargo test --test all -- --ignored"]
fn ranges_by_phase_keep_their_budget() {
    assert_ranging("M4F");
}

#[test]
#[ignore = "needs an image of frames for the Cortex-M0: cargo test --test all -- --ignored"]
fn ranges_by_phase_keep_their_budget_on_cortex_m0() {
    assert_ranging("M0");
}
