//! The board's register words against the chip maker's own description of its registers (the SVD file, by way of
//! the crate `stm32f4`): every field by its name, every choice by its meaning.

use picket_firmware::nucleo_f446re::words::clock::{Source, Speed, Tree};
use picket_firmware::nucleo_f446re::words::sampling::{self, Sampling};
use picket_firmware::nucleo_f446re::words::waveform::{
    DAC_CR, DAC_REST, DAC_SR_UNDERRUN, DAC_STREAM, SyncInput, SyncOutput,
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
fn converters_of_real_records() {
    use chip::{adc_common, adc1};
    let tree = Tree::new(Speed::Mhz180, Source::HsePll);
    let converter = Sampling::plan(&tree, 100e3, false).unwrap().converter(&tree);
    let common = word(|w: &mut adc_common::ccr::W| w.multi().independent().adcpre().div4());
    let cr1 = word(|w: &mut adc1::cr1::W| w.ovrie().enabled().res().twelve_bit());
    let cr2 = word(|w: &mut adc1::cr2::W| {
        w.adon().enabled().cont().single().dma().enabled().dds().continuous();
        w.extsel().tim3trgo().exten().rising_edge()
    });
    let smpr2 = word(|w: &mut adc1::smpr2::W| w.smp0().cycles144().smp1().cycles144());
    // SAFETY: the numbers fit their fields.
    let sqr3 = word(|w: &mut adc1::sqr3::W| unsafe { w.sq1().bits(0) });
    assert_eq!((converter.common, converter.cr1, converter.cr2), (common, cr1, cr2));
    assert_eq!((converter.smpr2, converter.sqr3), (smpr2, sqr3));
    assert!(says(sampling::ADC_SR_OVR, |r: &adc1::sr::R| r.ovr().is_overrun()));
}

#[test]
fn converters_of_iq_records() {
    use chip::{adc_common, adc1};
    let tree = Tree::new(Speed::Mhz180, Source::HsePll);
    let converter = Sampling::plan(&tree, 1.5e6, true).unwrap().converter(&tree);
    let common = word(|w: &mut adc_common::ccr::W| {
        w.multi().dual_r().dma().mode2().dds().continuous().adcpre().div4()
    });
    let cr2 = word(|w: &mut adc1::cr2::W| {
        w.adon().enabled().cont().continuous().extsel().tim3trgo().exten().rising_edge()
    });
    let second = word(|w: &mut adc1::cr2::W| w.adon().enabled().cont().continuous());
    // SAFETY: the numbers fit their fields.
    let sqr3 = word(|w: &mut adc1::sqr3::W| unsafe { w.sq1().bits(1) });
    assert_eq!((converter.common, converter.cr2), (common, cr2));
    assert_eq!((converter.second_cr2, converter.second_sqr3), (second, sqr3));
}

#[test]
fn streams() {
    use chip::dma2::{lisr, st};
    let tree = Tree::new(Speed::Mhz180, Source::HsePll);
    for iq in [false, true] {
        let stream = Sampling::plan(&tree, 1e5, iq).unwrap().stream();
        let control = word(|w: &mut st::cr::W| {
            // SAFETY: a number of three bits.
            unsafe { w.chsel().bits(0) };
            w.dbm().enabled().pl().very_high().minc().incremented();
            w.circ().enabled().tcie().enabled().teie().enabled().dmeie().enabled();
            w.dir().peripheral_to_memory();
            if iq {
                w.msize().bits32().psize().bits32()
            } else {
                w.msize().bits16().psize().bits16()
            }
        });
        assert_eq!(stream.control, control);
    }
    let dac = word(|w: &mut st::cr::W| {
        // SAFETY: a number of three bits.
        unsafe { w.chsel().bits(7) };
        w.pl().high().msize().bits16().psize().bits16().minc().incremented();
        w.circ().enabled().dir().memory_to_peripheral()
    });
    assert_eq!(DAC_STREAM, dac);
    assert_eq!(sampling::STREAM_EN, word(|w: &mut st::cr::W| w.en().enabled()));
    assert_eq!(sampling::STREAM_CT, word(|w: &mut st::cr::W| w.ct().memory1()));
    let flags = |asks: fn(&lisr::R) -> bool, word| says(word, asks);
    assert!(flags(|r: &lisr::R| r.tcif0().is_complete(), sampling::STREAM_0_COMPLETE));
    assert!(flags(|r| r.teif0().is_error() && r.dmeif0().is_error(), sampling::STREAM_0_ERRORS));
    assert!(flags(
        |r| !r.feif0().is_error() && !r.tcif0().is_complete(),
        sampling::STREAM_0_ERRORS
    ));
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
