//! The NUCLEO's real image from power-on, on rsemu's model of the chip: what a board would show at its first power-up.

mod source;

#[test]
fn it_builds() {
    println!("{:?}", source::program());
}
