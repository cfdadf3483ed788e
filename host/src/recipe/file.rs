//! The file of a recording: the whole of it, or as an array the records that its waveform has.

use picket_simulator::Scene;
use std::io::Cursor;
use std::path::Path;

/// What a file of these codes holds: a WAV by its name, else raw integers.
///
/// # Errors
/// A WAV cannot state the rate.
pub fn bytes(file: &Path, scene: &Scene, codes: &[[i16; 2]]) -> Result<Vec<u8>, String> {
    let channels = if scene.receiver.iq { 2 } else { 1 };
    let words = codes.iter().flat_map(|code| code.iter().take(channels));
    if !file.extension().is_some_and(|end| end.eq_ignore_ascii_case("wav")) {
        return Ok(words.flat_map(|word| word.to_le_bytes()).collect());
    }
    // A cast saturates.
    let sample_rate = scene.rate_hz as u32;
    if sample_rate == 0 || f64::from(sample_rate) != scene.rate_hz {
        let rate_hz = scene.rate_hz;
        return Err(format!(
            "a WAV has whole hertz, not {rate_hz} Hz: name the file .i16, or set another rate_hz"
        ));
    }
    let spec = hound::WavSpec {
        channels: channels as u16,
        sample_rate,
        bits_per_sample: 16,
        sample_format: hound::SampleFormat::Int,
    };
    let mut bytes = Cursor::new(Vec::new());
    let written = hound::WavWriter::new(&mut bytes, spec).and_then(|mut wav| {
        words.copied().try_for_each(|word| wav.write_sample(word))?;
        wav.finalize()
    });
    written.map_err(|error| format!("{}: {error}", file.display()))?;
    Ok(bytes.into_inner())
}

/// An array of NumPy's of these codes, and its sides: (records, samples) where the scene's waveform has records, and 2 for I and Q.
pub fn array(scene: &Scene, codes: &[[i16; 2]]) -> (Vec<u8>, String) {
    let parts = if scene.receiver.iq { 2 } else { 1 };
    let n = scene.waveform.as_ref().filter(|wave| wave.guard_s.is_some()).map(|wave| wave.samples);
    let sides = match n.filter(|n| *n > 0) {
        Some(n) => format!("{}, {n}", codes.len() / n),
        None => codes.len().to_string(),
    };
    let sides = match (parts, sides.contains(',')) {
        (2, _) => format!("{sides}, 2"),
        (_, true) => sides,
        (_, false) => format!("{sides},"),
    };
    let header = format!("{{'descr': '<i2', 'fortran_order': False, 'shape': ({sides}), }}\n");
    let words = codes.iter().flat_map(|code| code.iter().take(parts));
    let data: Vec<u8> = words.flat_map(|word| word.to_le_bytes()).collect();
    let length = (header.len() as u16).to_le_bytes();
    ([b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), &data].concat(), sides)
}

/// What the file is, in a line.
pub fn line(scene: &Scene, samples: usize) -> String {
    let (rate_hz, converter) = (scene.rate_hz, &scene.converter);
    let kind = if scene.receiver.iq { "I/Q" } else { "real" };
    let sign = if converter.unsigned { "from 0 on" } else { "signed" };
    let seconds = samples as f64 / rate_hz;
    format!("{seconds:.4} s at {rate_hz} Hz, {kind}, {} bits, {sign}", converter.bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_array_has_the_records() {
        let waveform = picket_simulator::scene::Waveform {
            shape: picket_simulator::scene::Shape::Sawtooth,
            carrier_hz: 24e9,
            bandwidth_hz: 2e8,
            ramp_s: 1.1e-3,
            period_s: 2e-3,
            guard_s: Some(1e-5),
            samples: 1000,
            ..picket_simulator::scene::Waveform::default()
        };
        let mut scene = Scene { rate_hz: 1e6, seconds: 0.01, ..Scene::default() };
        let made = |scene: &Scene| array(scene, &scene.codes(0).unwrap());
        assert!(made(&scene).1 == "10000,");
        scene.waveform = Some(waveform);
        let (bytes, sides) = made(&scene);
        assert_eq!((&sides[..], &bytes[..6]), ("5, 1000", &b"\x93NUMPY"[..]));
        scene.receiver.iq = true;
        let (twice, sides) = made(&scene);
        assert_eq!((&sides[..], twice.len()), ("5, 1000, 2", bytes.len() + 3 + 10_000));
    }

    #[test]
    fn a_file_is_of_its_kind() {
        let mut scene = Scene { rate_hz: 48e3, ..Scene::default() };
        let codes = [[1, -2], [300, -400]];
        let raw = bytes(Path::new("x.i16"), &scene, &codes).unwrap();
        assert_eq!(raw, [1, 0, 44, 1]);
        scene.receiver.iq = true;
        let raw = bytes(Path::new("x.i16"), &scene, &codes).unwrap();
        assert_eq!(raw, [1, 0, 254, 255, 44, 1, 112, 254]);
        let wav = bytes(Path::new("x.WAV"), &scene, &codes).unwrap();
        let mut read = hound::WavReader::new(&wav[..]).unwrap();
        assert_eq!((read.spec().channels, read.spec().sample_rate), (2, 48_000));
        let words: Vec<i16> = read.samples().map(Result::unwrap).collect();
        assert_eq!(words, [1, -2, 300, -400]);
        scene.rate_hz = 0.5;
        assert!(bytes(Path::new("x.wav"), &scene, &codes).unwrap_err().contains("whole hertz"));
    }
}
