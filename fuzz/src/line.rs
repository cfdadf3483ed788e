//! What comes over the line.

use picket_firmware::nucleo_f446re::words::Words;
use picket_firmware::nucleo_f446re::words::clock::{Source, Speed, Tree};
use picket_wire::boot::Boot;
use picket_wire::burst::Burst;
use picket_wire::chirp_frame::{ChirpFrame, Found};
use picket_wire::command::{Answer, Command, Request};
use picket_wire::follow::Follow;
use picket_wire::frame::{self, Frame, Kind, PAYLOAD, Reader};
use picket_wire::fundamental::Fundamental;
use picket_wire::lines::Lines;
use picket_wire::settings::Settings;
use picket_wire::status::{Raw, Status};
use picket_wire::sum::Sum;
use picket_wire::telemetry::Telemetry;

/// Bytes as they come over a line. Each frame that is accepted is what its sender would have sent.
pub fn frame(bytes: &[u8]) {
    let mut reader = Reader::default();
    for &byte in bytes {
        if let Some(Ok(frame)) = reader.push(byte)
            && frame.payload.len() <= PAYLOAD
        {
            let again = frame::encode(frame.kind, &frame.payload).expect("it came as a frame");
            assert_eq!(read(&again), frame);
        }
    }
}

/// The only frame in these bytes.
fn read(wire: &[u8]) -> Frame {
    let mut reader = Reader::default();
    let mut frames = wire.iter().filter_map(|&byte| reader.push(byte));
    let frame = frames.next().expect("a frame").expect("a whole frame");
    assert!(frames.next().is_none());
    frame
}

/// A kind and a payload whose checksum was right. What is understood comes back as it was.
pub fn message(bytes: &[u8]) {
    let Some((&kind, payload)) = bytes.split_first() else { return };
    let Ok(payload) = payload.try_into() else { return };
    let Some(kind) = Kind::from_u8(kind) else { return };
    let frame = Frame { kind, payload };
    match kind {
        Kind::Telemetry => same(&frame, |it| Telemetry::from_frame(it).ok(), |it| it.to_frame()),
        Kind::Boot => same(&frame, |it| Boot::from_frame(it).ok(), |it| it.to_frame()),
        Kind::Status => same(&frame, |it| Status::from_frame(it).ok(), |it| it.to_frame()),
        Kind::Raw => same(&frame, Raw::from_frame, |it| it.to_frame()),
        Kind::Follow => same(&frame, |it| Follow::from_frame(it).ok(), |it| it.to_frame()),
        Kind::Lines => same(&frame, |it| Lines::from_frame(it).ok(), |it| it.to_frame()),
        Kind::Fundamental => {
            same(&frame, |it| Fundamental::from_frame(it).ok(), |it| it.to_frame())
        }
        Kind::Burst => same(&frame, |it| Burst::from_frame(it).ok(), |it| it.to_frame()),
        Kind::Sum => same(&frame, |it| Sum::from_frame(it).ok(), |it| it.to_frame()),
        Kind::ChirpFrame => same(&frame, |it| ChirpFrame::from_frame(it).ok(), |it| it.to_frame()),
        Kind::Found => same(&frame, |it| Found::from_frame(it).ok(), |it| it.to_frame()),
        Kind::Command => drop(Request::from_frame(&frame)),
        Kind::Reply | Kind::Refusal => {
            if let Some((answer, said)) = Answer::from_frame(&frame) {
                let again = match said {
                    Ok(body) => answer.reply(body),
                    Err(refusal) => answer.refusal(refusal),
                };
                // A body that no frame holds is not sent.
                let again = (!again.is_empty()).then(|| read(&again));
                let told = again.as_ref().map(|it| Answer::from_frame(it).expect("an answer"));
                assert!(told.is_none_or(|told| told == (answer, said)));
            }
        }
        Kind::End => {}
    }
}

/// What `of` reads in a frame is sent by `to` so that `of` reads the same again.
fn same<T, W: AsRef<[u8]>>(frame: &Frame, of: impl Fn(&Frame) -> Option<T>, to: impl Fn(&T) -> W) {
    if let Some(first) = of(frame) {
        let sent = to(&first);
        let second = of(&read(sent.as_ref())).expect("what was sent is understood");
        // Bytes, not values: a value that is no number is not equal to itself.
        assert_eq!(to(&second).as_ref(), sent.as_ref());
    }
}

/// A command whose checksum was right.
pub fn command(bytes: &[u8]) {
    let Ok(payload) = bytes.try_into() else { return };
    let Ok(request) = Request::from_frame(&Frame { kind: Kind::Command, payload }) else { return };
    assert_eq!([request.tag, request.command.number()], bytes[..2]);
    match request.command {
        Command::SetSettings(settings, n) => {
            let again = settings.to_bytes(n);
            let (told, length) = Settings::from_bytes(&again).expect("settings of ours");
            assert_eq!((told.to_bytes(length), length), (again, n));
        }
        Command::Capture(blocks) => assert_eq!(blocks.to_le_bytes(), bytes[2..]),
        _ => assert_eq!(bytes.len(), 2),
    }
}

/// Settings, as a host sends them and as flash keeps them. What is stored again is read the same; what a board answers does not
/// change when it is set again.
pub fn settings(bytes: &[u8]) {
    let Ok((settings, n)) = Settings::from_bytes(bytes) else { return };
    let (told, length) = Settings::from_bytes(&settings.to_bytes(n)).expect("settings of ours");
    assert_eq!((told.to_bytes(length), length), (settings.to_bytes(n), n));
    let speed = Speed::from_mhz(settings.core_mhz).unwrap_or_default();
    let tree = Tree::new(speed, Source::HsePll);
    if let Ok((plan, _)) = Words::plan::<1024>(&settings, &tree) {
        let again = Words::plan::<1024>(&plan.settings, &tree);
        let (again, _) = again.expect("settings that were answered");
        assert_eq!(again.settings, plan.settings, "settings that were set again");
    }
}
