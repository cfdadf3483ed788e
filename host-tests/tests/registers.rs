//! The board's register words against the chip maker's own description of its registers (the SVD file, by way of
//! the crate `stm32f4`): every field by its name, every choice by its meaning.

use picket_firmware::nucleo_f446re::words::sampling;
use picket_firmware::nucleo_f446re::words::waveform::{
    DAC_CR, DAC_REST, DAC_SR_UNDERRUN, SyncInput, SyncOutput,
};
use stm32f4::stm32f446 as chip;
use stm32f4::{R, Readable, Reg, RegisterSpec, W, Writable};

/// The word that naming these fields makes, over zeros.
fn word<REG: RegisterSpec + Writable>(name: impl FnOnce(&mut W<REG>) -> &mut W<REG>) -> u32
where
    REG::Ux: Into<u32>,
{
    let memory = std::cell::UnsafeCell::new(0u32);
    // SAFETY: a register is a cell of at most this width, and this one is only memory.
    unsafe { (*memory.get().cast::<Reg<REG>>()).write_with_zero(name) }.into()
}

/// What a register that holds `word` says.
fn says<REG: RegisterSpec<Ux = u32> + Readable>(
    word: u32,
    asks: impl FnOnce(&R<REG>) -> bool,
) -> bool {
    let memory = std::cell::UnsafeCell::new(word);
    // SAFETY: a register is a cell of its width, and this one is only memory.
    let register = unsafe { &*memory.get().cast::<Reg<REG>>() };
    asks(&register.read())
}

#[test]
fn chirp_and_synchronisation() {
    use chip::{dac, tim2};
    let control = word(|w: &mut dac::cr::W| {
        w.en1().enabled().ten1().enabled().tsel1().tim4trgo().dmaen1().enabled()
    });
    assert_eq!(DAC_CR, control);
    assert_eq!(DAC_REST, word(|w: &mut dac::cr::W| w.en1().enabled().tsel1().tim4trgo()));
    assert!(says(DAC_SR_UNDERRUN, |r: &dac::sr::R| r.dmaudr1().is_underrun()));
    assert_eq!(sampling::TIMER_CR2_UPDATE, word(|w: &mut tim2::cr2::W| w.mms().update()));
    assert_eq!(
        sampling::TIMER_SMCR_COUNT_TIM3,
        word(|w: &mut tim2::smcr::W| w.ts().itr2().sms().ext_clock_mode())
    );
    let output = SyncOutput::new(3, 1088);
    let mode = word(|w: &mut tim2::ccmr2_output::W| {
        w.cc3s().output().oc3m().pwm_mode1().oc3pe().enabled()
    });
    let enable = word(|w: &mut tim2::ccer::W| w.cc3e().enabled());
    assert_eq!((output.mode, output.enable), (mode, enable));
    let input = SyncInput::new(1000).unwrap();
    let one_pulse = word(|w: &mut tim2::cr1::W| w.opm().enabled());
    let first_output = word(|w: &mut tim2::cr2::W| w.mms().compare_oc1());
    let start = word(|w: &mut tim2::smcr::W| w.ts().ti2fp2().sms().trigger_mode());
    let gate = word(|w: &mut tim2::smcr::W| w.ts().itr1().sms().gated_mode());
    assert_eq!((input.control, input.control2), (one_pulse, first_output));
    assert_eq!((input.slave, input.gate), (start, gate));
    // One half of the register is an output, the other an input: two views of it.
    let compare = word(|w: &mut tim2::ccmr1_output::W| w.oc1m().pwm_mode2());
    let capture = word(|w: &mut tim2::ccmr1_input::W| w.cc2s().ti2().ic2f().fck_int_n8());
    assert_eq!(input.mode, compare | capture);
}
