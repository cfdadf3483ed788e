//! `picket simulate`: the recording of a scene, and what is true of it.

mod file;
mod truth;

use crate::cli;
use crate::output::Output;
use clap::Args;
use picket_simulator::scene::Source;
use picket_simulator::{Scene, Value};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use truth::Told;

/// The scenes of docs/recipes.
const RECIPES: [(&str, &str); 5] = [
    ("hb100", include_str!("scenes/hb100.json")),
    ("laser", include_str!("scenes/laser.json")),
    ("fmcw", include_str!("scenes/fmcw.json")),
    ("cars", include_str!("scenes/cars.json")),
    ("tank", include_str!("scenes/tank.json")),
];

/// Simulates a sensor and writes its recording: a recipe of docs/recipes, or a scene in a JSON file (docs/scenes.md). Prints the truth.
#[derive(Args, Debug)]
pub struct Options {
    /// hb100 (a person who walks), laser (particles in fringes), fmcw (a corner reflector), cars (frames of chirps), tank (a level), or the JSON
    /// file of a scene
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// The file to write: a .wav of 16 bits; a .npy with a row for each record, if the scene's waveform has samples; or raw little-endian
    /// 16-bit integers. I and Q in turn
    file: PathBuf,
    /// Distance of the first source at the start, m [default: the scene's]
    #[arg(long, value_name = "M", value_parser = cli::positive)]
    range_m: Option<f64>,
    /// Its velocity towards the sensor, m/s [default: the scene's]
    #[arg(long, value_name = "M/S", allow_negative_numbers = true, value_parser = cli::number)]
    velocity_mps: Option<f64>,
    /// Seed of noise, phases and arrivals [default: the scene's]
    #[arg(long)]
    seed: Option<u64>,
    /// Also writes time, frequency, amplitude, range and velocity of each source, as CSV
    #[arg(long, value_name = "CSV")]
    truth: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

/// The scene of a recipe's name or of a file.
///
/// # Errors
/// In one line, why there is none.
pub fn scene(name: &Path) -> Result<Scene, String> {
    let told = |error| format!("{}: {error}", name.display());
    if let Some((_, json)) = RECIPES.iter().find(|(recipe, _)| name == Path::new(recipe)) {
        return Scene::from_json(json).map_err(told);
    }
    let json = fs::read_to_string(name).map_err(|error| {
        let names = RECIPES.map(|(recipe, _)| recipe).join(", ");
        format!("{}: {error}; give {names} or the JSON file of a scene", name.display())
    })?;
    Scene::from_json(&json).map_err(told)
}

/// Puts the first source at a range.
fn place(scene: &mut Scene, metres: f64) -> Result<(), String> {
    let range_m = match scene.sources.first_mut() {
        Some(Source::Target(of)) => &mut of.range_m,
        Some(Source::Blades(of)) => &mut of.range_m,
        Some(Source::Walker(of)) => &mut of.range_m,
        _ => return Err("--range-m: the first source has no range: leave it out".into()),
    };
    *range_m = metres.into();
    Ok(())
}

/// Gives the first source a velocity. A flow keeps its turbulence as a share of its speed.
fn drive(scene: &mut Scene, mps: f64) -> Result<(), String> {
    let velocity_mps = match scene.sources.first_mut() {
        Some(Source::Target(of)) => &mut of.velocity_mps,
        Some(Source::Blades(of)) => &mut of.velocity_mps,
        Some(Source::Walker(of)) => &mut of.velocity_mps,
        Some(Source::Particles(of)) => {
            if let Value::Fixed(before) = of.velocity_mps
                && before != 0.0
            {
                of.turbulence_mps *= (mps / before).abs();
            }
            &mut of.velocity_mps
        }
        _ => return Err("--velocity-mps: the first source has no velocity: leave it out".into()),
    };
    *velocity_mps = mps.into();
    Ok(())
}

/// Writes the recording and prints what is true of it.
///
/// # Errors
/// In one line, what is wrong with the scene or a file.
pub fn run(options: &Options) -> Result<ExitCode, String> {
    let Options { scene: ref name, ref file, ref truth, output, .. } = *options;
    let mut scene = scene(name)?;
    scene.seed = options.seed.unwrap_or(scene.seed);
    options.range_m.map_or(Ok(()), |metres| place(&mut scene, metres))?;
    options.velocity_mps.map_or(Ok(()), |mps| drive(&mut scene, mps))?;
    output.check(file, &[name])?;
    if let Some(truth) = truth {
        output.check(truth, &[name])?;
        if truth == file {
            return Err("--truth: name another file than that of the recording".into());
        }
    }
    let told = |error| format!("{}: {error}", name.display());
    let known = Told::new(&scene).map_err(told)?;
    let codes = scene.codes(0).map_err(told)?;
    let mut what = file::line(&scene, codes.len());
    if file.extension().is_some_and(|end| end.eq_ignore_ascii_case("npy")) {
        let (bytes, sides) = file::array(&scene, &codes);
        output.write(file, &bytes)?;
        what = format!("({}), {what}", sides.trim_end_matches(','));
    } else {
        output.write(file, &file::bytes(file, &scene, &codes)?)?;
    }
    if let Some(truth) = truth {
        output.write(truth, known.csv().as_bytes())?;
    }
    outln!("{}: {what}", file.display());
    for line in known.lines() {
        outln!("{line}");
    }
    Ok(ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The recipes, and the scenes of the documents.
    fn all() -> Vec<Scene> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/scenes");
        let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let names = RECIPES.iter().map(|(recipe, _)| PathBuf::from(recipe));
        names.chain(files).map(|name| scene(&name).unwrap()).collect()
    }

    #[test]
    fn every_scene_runs_and_its_truth_is_whole() {
        let scenes = all();
        assert!(scenes.len() >= RECIPES.len() + 2);
        for scene in scenes {
            let codes = scene.codes(0).unwrap();
            let taken = scene.waveform.as_ref().filter(|wave| wave.guard_s.is_some());
            let count = match taken.map(|wave| wave.samples) {
                Some(n) => (n * scene.records(n)) as f64,
                None => scene.seconds * scene.rate_hz,
            };
            assert_eq!(codes.len() as f64, count, "{}", scene.about);
            let told = Told::new(&scene).unwrap();
            assert_eq!(told.lines().len(), scene.sources.len(), "{}", scene.about);
            let csv = told.csv();
            let columns = |line: &str| line.split(',').count();
            assert!(csv.lines().count() > 2 && csv.lines().all(|line| columns(line) == 8), "{csv}");
        }
    }

    #[test]
    fn the_first_source_goes_where_it_is_put() {
        let [mut hb100, mut laser, ..] = RECIPES.map(|(_, json)| Scene::from_json(json).unwrap());
        place(&mut hb100, 30.0).unwrap();
        drive(&mut hb100, -0.7).unwrap();
        let truth = hb100.run(0).unwrap().truth(0, 0.0, 4);
        assert!((truth.range_m.unwrap() - 30.0).abs() < 0.01);
        assert!((truth.velocity_mps.unwrap() + 0.7).abs() < 0.081);
        assert!(place(&mut laser, 1.0).unwrap_err().contains("no range"));
        drive(&mut laser, 0.1).unwrap();
        let run = laser.run(0).unwrap();
        let speeds = run.particles(0).iter().map(|particle| particle.velocity_mps);
        let mean = speeds.sum::<f64>() / run.particles(0).len() as f64;
        // 5 % of turbulence, over a hundred particles.
        assert!((mean - 0.1).abs() < 0.002, "{mean}");
        // It walks past the sensor.
        drive(&mut hb100, 5.0).unwrap();
        let error = Told::new(&hb100).err().unwrap();
        assert!(error.contains("reaches the sensor") && !error.contains('\n'), "{error}");
    }

    #[test]
    fn what_is_no_scene_is_told() {
        let error = scene(Path::new("no-such")).unwrap_err();
        assert!(error.contains("give hb100, laser, fmcw, cars, tank or the JSON file"), "{error}");
    }
}
