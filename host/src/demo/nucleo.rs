//! The NUCLEO's image for sums and bursts on its emulator, where the host plays the converters: a scene slowed down to what the board
//! reaches. A bin stays a bin, and a sample a sample.

use super::{DemoError, said};
use crate::board::{Board, image};
use crate::device::Said;
use crate::toolchain::{Need, Target, have};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::config::{Config, Scene};
use picket_firmware::nucleo_f446re::N;
use picket_wire::command::Command;
use picket_wire::settings::{Mode, Settings};

/// The board's rate, Hz.
const RATE_HZ: f64 = 200e3;
/// The middle of the converter's codes.
const MIDDLE: i16 = 2048;
/// Turns of the loop in which the last block is measured.
const TURNS: usize = 8;

/// The board, measuring.
pub struct Nucleo(Board);

impl Nucleo {
    /// The board with a scene's configuration, in one of the image's modes.
    pub fn start(config: Config, iq: bool, mode: Mode) -> Result<Self, DemoError> {
        have(&[Need::Core(Target::M4f), Need::Emulator]).map_err(said)?;
        let scene = match config.scene {
            Scene::Doppler { wavelength_m, angle_rad, mixing } => {
                // An equal velocity, at a frequency that is lower by the ratio of the rates.
                let wavelength_m = wavelength_m * config.rate_hz / RATE_HZ;
                Scene::Doppler { wavelength_m, angle_rad, mixing }
            }
            other => other,
        };
        let codes = Codes::unsigned::<12>();
        let config = Config { rate_hz: RATE_HZ, codes, scene, ..config };
        let settings = Settings { iq, config, mode, ..Settings::default() };
        let mut board = Board::start(&image(true, false).map_err(said)?).map_err(said)?;
        let begun = |said| matches!(said, Said::Boot(boot) if boot.measuring).then_some(());
        board.expect(begun).map_err(said)?;
        let refused = |refusal| said(format!("the board refuses: {refusal}"));
        let command = Command::SetSettings(settings, N);
        board.request(command).map_err(said)?.map_err(refused)?;
        board.expect(begun).map_err(said)?;
        Ok(Self(board))
    }

    /// Plays a block of codes about 0, of an I/Q record the pairs one after the other. Gives what the board has said meanwhile: what it
    /// measures may come with the next block.
    pub fn block(&mut self, codes: &[i16]) -> Result<Vec<Said>, DemoError> {
        let Self(board) = self;
        let bytes: Vec<u8> = codes.iter().flat_map(|code| (code + MIDDLE).to_le_bytes()).collect();
        match board.block(&bytes).map_err(said)? {
            true => board.turn().map_err(said),
            false => Err(said("the board has stopped")),
        }
    }

    /// What is left to say.
    pub fn rest(&mut self) -> Result<Vec<Said>, DemoError> {
        let Self(board) = self;
        let mut rest = Vec::new();
        for _ in 0..TURNS {
            rest.extend(board.turn().map_err(said)?);
        }
        Ok(rest)
    }
}
