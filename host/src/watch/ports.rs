//! Which serial ports there are, and what to do where one does not open.

use serialport::{SerialPortInfo, SerialPortType, UsbPortInfo};
use std::io::ErrorKind;

/// ST's number: the board's own programmer.
const BOARD: u16 = 0x0483;
/// What a Pico with Picket calls itself.
const PICO: &str = "Picket on a Pico";

/// A udev rule for Linux that lets every user at the machine use the board.
pub const UDEV: &str = "\
# The NUCLEO's programmer and serial port, for whoever sits at the machine and for the group dialout:
#   picket watch --install-udev | sudo tee /etc/udev/rules.d/70-picket.rules
#   sudo udevadm control --reload && sudo udevadm trigger
# ModemManager leaves them alone.
SUBSYSTEM==\"tty\", ATTRS{idVendor}==\"0483\", MODE=\"0660\", GROUP=\"dialout\", TAG+=\"uaccess\", ENV{ID_MM_DEVICE_IGNORE}=\"1\"
SUBSYSTEM==\"usb\", ATTRS{idVendor}==\"0483\", MODE=\"0660\", GROUP=\"dialout\", TAG+=\"uaccess\", ENV{ID_MM_DEVICE_IGNORE}=\"1\"
SUBSYSTEM==\"tty\", ATTRS{product}==\"Picket on a Pico\", MODE=\"0660\", GROUP=\"dialout\", TAG+=\"uaccess\", ENV{ID_MM_DEVICE_IGNORE}=\"1\"
SUBSYSTEM==\"usb\", ATTR{product}==\"Picket on a Pico\", ENV{ID_MM_DEVICE_IGNORE}=\"1\"
";

/// A line for each port of this machine that a board may be at, the board's first, and the name of the first. Ports without USB are the
/// machine's own, and counted.
pub fn list() -> (Vec<String>, Option<String>) {
    // A machine that does not tell its ports has none that can be listed.
    described(serialport::available_ports().unwrap_or_default())
}

fn described(ports: Vec<SerialPortInfo>) -> (Vec<String>, Option<String>) {
    let plugged = |port: &SerialPortInfo| {
        matches!(port.port_type, SerialPortType::UsbPort(_) | SerialPortType::BluetoothPort)
    };
    let (mut ports, own): (Vec<_>, Vec<_>) = ports.into_iter().partition(plugged);
    ports.sort_by_key(|port| {
        let rank = match &port.port_type {
            SerialPortType::UsbPort(usb)
                if usb.vid == BOARD || usb.product.as_deref() == Some(PICO) =>
            {
                0
            }
            SerialPortType::UsbPort(_) => 1,
            _ => 2,
        };
        (rank, port.port_name.clone())
    });
    let lines = ports.iter().map(|port| {
        let what = match &port.port_type {
            SerialPortType::UsbPort(usb) => of_usb(usb),
            SerialPortType::BluetoothPort => "Bluetooth".into(),
            _ => String::new(),
        };
        format!("{:16} {what}", port.port_name)
    });
    let mut lines: Vec<String> = lines.collect();
    if let [first, rest @ ..] = &own[..] {
        let name = &first.port_name;
        lines.push(match rest.len() {
            0 => format!("{name} is left out, because it is no USB port: it works by its name"),
            more => format!(
                "{name} and {more} more are left out, because they are no USB ports: each works by its name"
            ),
        });
    }
    (lines, ports.first().map(|port| port.port_name.clone()))
}

fn of_usb(usb: &UsbPortInfo) -> String {
    let names = [&usb.manufacturer, &usb.product].map(|name| name.as_deref().unwrap_or_default());
    let board = if usb.vid == BOARD { ", a NUCLEO or another board of ST's" } else { "" };
    format!("{} (USB {:04x}:{:04x}{board})", names.join(" ").trim(), usb.vid, usb.pid)
}

/// Why a port does not open, and the cure.
pub fn cure(error: &serialport::Error) -> String {
    let said = error.to_string();
    let has = |word: &str| said.to_ascii_lowercase().contains(word);
    match error.kind() {
        serialport::ErrorKind::Io(ErrorKind::NotFound) => {
            "no such port: plug the board in by its USB socket, `picket watch` alone lists the ports".into()
        }
        serialport::ErrorKind::Io(ErrorKind::PermissionDenied) => {
            "you may not open it: type `sudo usermod -aG dialout $USER` and log in again, or use the rule of `picket watch --install-udev`".into()
        }
        _ if has("busy") || has("lock") => {
            "another program uses it: close that (a terminal, an IDE's monitor, ModemManager) and try again".into()
        }
        _ if has("typewriter") || has("ioctl") || has("directory") => {
            "it is no serial port: --replay reads a recorded file, `picket watch` alone lists the ports".into()
        }
        _ if has("no such device") || has("not configured") || has("input/output") => {
            "its device is gone: plug the board in again".into()
        }
        _ => said,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn port(name: &str, vid: u16) -> SerialPortInfo {
        let usb = UsbPortInfo {
            vid,
            pid: 0x374b,
            serial_number: None,
            manufacturer: Some("STMicroelectronics".into()),
            product: Some("STM32 STLink".into()),
        };
        SerialPortInfo { port_name: name.into(), port_type: SerialPortType::UsbPort(usb) }
    }

    #[test]
    fn the_boards_port_comes_first() {
        let plain =
            SerialPortInfo { port_name: "/dev/ttyS0".into(), port_type: SerialPortType::Unknown };
        let ports = vec![plain.clone(), port("/dev/ttyACM0", 0x2341), port("/dev/ttyACM1", BOARD)];
        let (lines, first) = described(ports);
        assert_eq!(first.as_deref(), Some("/dev/ttyACM1"));
        assert!(lines[0].contains("STMicroelectronics STM32 STLink (USB 0483:374b, a NUCLEO"));
        assert!(lines[1].starts_with("/dev/ttyACM0"), "{lines:?}");
        // The machine's own port is no board.
        let (lines, first) = described(vec![plain]);
        assert!(first.is_none() && lines.len() == 1 && lines[0].contains("left out"), "{lines:?}");
    }

    #[test]
    fn each_failure_has_its_cure() {
        use serialport::{Error, ErrorKind as Kind};
        let io = |kind| Kind::Io(kind);
        for (kind, said, cured) in [
            (io(ErrorKind::NotFound), "No such file or directory", "plug the board in"),
            (io(ErrorKind::PermissionDenied), "Permission denied", "dialout"),
            (Kind::NoDevice, "Device or resource busy", "another program uses it"),
            (Kind::Unknown, "Not a typewriter", "it is no serial port"),
            (Kind::Unknown, "No such device or address", "its device is gone"),
            (Kind::Unknown, "something new", "something new"),
        ] {
            let line = cure(&Error::new(kind, said));
            assert!(line.contains(cured) && !line.contains('\n'), "{said}: {line}");
        }
    }
}
