//! The emulator's program: rsemu as its registry has it, corrected in a few lines, and ours around it (`host-tests/rsemu`).

use picket_host::toolchain::{firmware_dir, workspace};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

const CRATE: &str = "rsemu-0.0.7";

/// A line of rsemu, and what stands there instead.
struct Correction {
    file: &'static str,
    from: &'static str,
    to: &'static str,
}

/// What is corrected, each once.
const CORRECTIONS: &[Correction] = &[
    // Registers of 16 bits may be accessed by half words (RM 20.4, 25.6).
    Correction { file: "src/dev/stm32/iwdg.rs", from: READ, to: HALF_READ },
    Correction { file: "src/dev/stm32/iwdg.rs", from: WRITE, to: HALF_WRITE },
    Correction { file: "src/dev/stm32/iwdg.rs", from: WORDS, to: HALF_WORDS },
    Correction { file: "src/dev/stm32/usart.rs", from: READ, to: HALF_READ },
    Correction { file: "src/dev/stm32/usart.rs", from: WRITE, to: HALF_WRITE },
    Correction { file: "src/dev/stm32/usart.rs", from: WORDS, to: HALF_WORDS },
    // An exception saves the whole of xPSR, the bits of an IT block among them (Armv7-M, B1.5.6).
    Correction {
        file: "src/cpu/arm/v7m/exec.rs",
        from: "(self.state.xpsr & !(xpsr::EXCEPTION | 0x0600_fc00)) |",
        to: "(self.state.xpsr & !(xpsr::EXCEPTION | 1 << 9)) |",
    },
    // A handler without floating point leaves FPSCR as it is: its default comes with the first instruction of a new context
    // (Armv7-M, B1.5.7 and ExecuteFPCheck). Else an interrupt between a comparison and the branch by it would lose the flags.
    Correction {
        file: "src/cpu/arm/v7m/exec.rs",
        from: "        #[cfg(feature = \"cpu-arm-v7m-fp\")]\n        if self.state.sys.fpccr & fpccr::ASPEN != 0 {\n            self.state.fp.fpscr = self.state.sys.fpdscr;\n        }\n",
        to: "",
    },
    Correction {
        file: "src/cpu/arm/v7m/exec.rs",
        from: "        if self.state.sys.fpccr & fpccr::ASPEN != 0 {\n            self.state.control |= control::FPCA;",
        to: "        if self.state.sys.fpccr & fpccr::ASPEN != 0 {
            if self.state.control & control::FPCA == 0 {
                let modes = 0x07C0_0000;
                self.state.fp.fpscr = self.state.fp.fpscr & !modes | self.state.sys.fpdscr & modes;
            }
            self.state.control |= control::FPCA;",
    },
    // In double-buffer mode the address that is not in use may be written; the one in use stops the stream with an error
    // (RM 9.3.10).
    Correction {
        file: "src/dev/stm32/dma.rs",
        from: "            (_, 0x0c) if !u.running => u.m0ar = value,\n            (Variant::Stream, 0x10) => u.m1ar = value,\n",
        to: "            (_, 0x0c) if !u.running || u.cr & (S_CR_DBM | S_CR_CT) == S_CR_DBM | S_CR_CT => u.m0ar = value,
            (Variant::Stream, 0x10) if !u.running || u.cr & (S_CR_DBM | S_CR_CT) != S_CR_DBM | S_CR_CT => u.m1ar = value,
            (_, 0x0c) | (Variant::Stream, 0x10) => {
                u.flags |= F_TE;
                u.cr &= !CR_EN;
                u.running = false;
                return 1 << unit;
            }
",
    },
    // What a disabled stream was asked for before is not served later.
    Correction {
        file: "src/dev/stm32/dma.rs",
        from: "            if !was_enabled && now_enabled {\n                self.arm(unit, &mut state);",
        to: "            if !was_enabled && now_enabled {
                for slot in &self.pending[unit] {
                    slot.store(false, Ordering::SeqCst);
                }
                self.arm(unit, &mut state);",
    },
    // A core that sleeps does so until the next event, in one step; one that flash holds executes nothing.
    Correction {
        file: "src/cpu/arm/v7m/mod.rs",
        from: "        while used < allowance {\n            let n = self.step();",
        to: "        while used < allowance && !(crate::STORED.swap(false, Ordering::Relaxed) && used > 0) {\n            let n = if self.dozes() { allowance - used } else { self.step() };",
    },
    // It ends the round, too. The core, which is the first that runs, has the first turn of each.
    Correction {
        file: "src/core/sched.rs",
        from: "        let target = match cut {\n            // A debugger's",
        to: "        let mut target = match cut {\n            // A debugger's",
    },
    Correction {
        file: "src/core/sched.rs",
        from: "            let index = (self.cursor + i) % count;\n            let id = RunnableId(index as u32);\n            let domain = self.runnables[index].domain;\n            let span = self.ticks_until(domain, target)?;",
        to: "            let index = i;\n            let id = RunnableId(index as u32);\n            let domain = self.runnables[index].domain;\n            let span = self.ticks_until(domain, target)?;",
    },
    Correction {
        file: "src/core/sched.rs",
        from: "            if used.ticks > 0 {\n                self.advance_runnable(domain, used.ticks)?;\n            }\n            consumed.push((id, used.ticks));\n        }\n        if count > 0 {",
        to: "            if used.ticks > 0 {\n                self.advance_runnable(domain, used.ticks)?;\n            }\n            if index == 0 && used.ticks < allowed {\n                let osc = self.forest.root_of(domain)?;\n                let here = self.forest.position(domain)?;\n                let at = self.forest.global_time_of_units(osc, here)?;\n                target = at.max(GlobalTime::from_raw(from.raw() + 1)).min(target);\n            }\n            consumed.push((id, used.ticks));\n        }\n        if count > 0 {",
    },
    // A store to a peripheral ends the core's turn: what it starts may have something to do before the turn's end.
    Correction {
        file: "src/cpu/arm/v7m/exec.rs",
        from: "        let attrs = self.attrs.with_privileged(privileged);\n        self.publish_position();\n        if addr.is_multiple_of(bytes) {\n            let width = width_of(bytes);\n            let value = self.to_cpu_order",
        to: "        let attrs = self.attrs.with_privileged(privileged);\n        self.publish_position();\n        if addr >> 29 == 2 {\n            crate::STORED.store(true, ::core::sync::atomic::Ordering::Relaxed);\n        }\n        if addr.is_multiple_of(bytes) {\n            let width = width_of(bytes);\n            let value = self.to_cpu_order",
    },
    Correction {
        file: "src/cpu/arm/v7m/mod.rs",
        from: "    /// Execute one reset sequence, one exception entry, or one instruction.\n",
        to: "    fn dozes(&self) -> bool {
        if crate::HELD.load(Ordering::Relaxed) {
            return true;
        }
        let quiet = self.lines.snapshot().iter().all(|word| *word == 0) && !self.lines.nmi();
        let session = self.session.lock();
        let state = &session.state;
        quiet && state.asleep && !state.reset_pending && state.sys.syst_csr & 1 == 0 && state.sys.highest_pending().is_none()
    }

    /// Execute one reset sequence, one exception entry, or one instruction.
",
    },
    Correction {
        file: "src/cpu/arm/v7m/sys.rs",
        from: "                    self.reset_requested = true;\n",
        to: "                    self.reset_requested = true;\n                    crate::RESET.store(true, ::core::sync::atomic::Ordering::SeqCst);\n",
    },
    // A serial port may fail.
    Correction {
        file: "src/dev/stm32/usart.rs",
        from: "        if self.variant == Variant::U5 {\n            return self.transmit_fifo();\n        }\n        let byte",
        to: "        if crate::MUTE.load(::core::sync::atomic::Ordering::SeqCst) {\n            return false;\n        }\n        let byte",
    },
    // A clock from outside may not come.
    Correction {
        file: "src/dev/stm32/rcc.rs",
        from: "            if is_on && !was_on {\n                state.ready_at[i]",
        to: "            if is_on && !was_on && bit.osc == Osc::Hse && crate::NO_HSE.load(Ordering::SeqCst) {\n                state.ready_at[i] = NO_DEADLINE;\n            } else if is_on && !was_on {\n                state.ready_at[i]",
    },
    Correction {
        file: "src/lib.rs",
        from: "pub mod core;\n",
        to: "pub mod core;\n/// The core stands still.\npub static HELD: ::core::sync::atomic::AtomicBool = ::core::sync::atomic::AtomicBool::new(false);\n/// The core has written to a peripheral.\npub static STORED: ::core::sync::atomic::AtomicBool = ::core::sync::atomic::AtomicBool::new(false);\n/// The core asked for a reset.\npub static RESET: ::core::sync::atomic::AtomicBool = ::core::sync::atomic::AtomicBool::new(false);\n/// The clock from outside is missing.\npub static NO_HSE: ::core::sync::atomic::AtomicBool = ::core::sync::atomic::AtomicBool::new(false);\n/// The serial port sends nothing.\npub static MUTE: ::core::sync::atomic::AtomicBool = ::core::sync::atomic::AtomicBool::new(false);\n",
    },
];

const READ: &str = "        let [a, b, c, d] = dst else {\n            return Err(BusError::BadAccess);\n        };\n";
const HALF_READ: &str = "        if let [x, y] = dst {
            let mut whole = [0u8; 4];
            self.read(offset & !3, &mut whole, attrs)?;
            (*x, *y) = (whole[0], whole[1]);
            return Ok(());
        }
        let [a, b, c, d] = dst else {
            return Err(BusError::BadAccess);
        };
";
const WRITE: &str = "        let [a, b, c, d] = src else {\n            return Err(BusError::BadAccess);\n        };\n";
const HALF_WRITE: &str = "        if let [x, y] = src {
            return self.write(offset & !3, &[*x, *y, 0, 0], attrs);
        }
        let [a, b, c, d] = src else {
            return Err(BusError::BadAccess);
        };
";
const WORDS: &str = "        AccessConstraints::word(Width::U32, Endian::Little)\n";
const HALF_WORDS: &str = "        AccessConstraints::word(Width::U32, Endian::Little).with_widths(Width::U16, Width::U32)\n";

/// The program, built at the first need.
pub fn program() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(build)
}

fn build() -> PathBuf {
    let place = firmware_dir().with_file_name("rsemu");
    let program = place.join("program");
    fs::create_dir_all(program.join("src")).unwrap();
    let lock = File::create(place.join("build.lock")).unwrap();
    lock.lock().unwrap();
    let ours = workspace().join("host-tests/rsemu");
    let files = [
        "Cargo.toml",
        "nucleo.machine",
        "src/main.rs",
        "src/adc.rs",
        "src/dac.rs",
        "src/bench.rs",
        "src/pulses.rs",
    ];
    files.iter().for_each(|file| copy(&ours.join(file), &program.join(file), |text| text));
    let source = place.join(CRATE);
    let done = source.join("corrected");
    let marks = format!("{}", CORRECTIONS.iter().map(|c| c.to.len() + c.from.len()).sum::<usize>());
    if fs::read_to_string(&done).ok().as_ref() != Some(&marks) {
        let original = original(&program);
        let _ = fs::remove_dir_all(&source);
        correct(&original, &source);
        fs::write(&done, marks).unwrap();
    }
    // The corrected source takes the place of the one that the lock names by its checksum; all else stays as it is locked.
    copy(&ours.join("Cargo.lock"), &program.join("Cargo.lock"), |text| {
        let of = |part: &str| format!("{part} = \"");
        let (head, rest) = text.split_once("name = \"rsemu\"").unwrap();
        let (own, others) = rest.split_once("\n\n").unwrap_or((rest, ""));
        let own = own
            .lines()
            .filter(|line| !["source", "checksum"].iter().any(|part| line.starts_with(&of(part))));
        let own = own.collect::<Vec<_>>().join("\n");
        format!("{head}name = \"rsemu\"{own}\n\n{others}")
    });
    let patch = format!("patch.crates-io.rsemu.path={source:?}");
    let output =
        cargo(&program, &["build", "--release", "--quiet", "--locked", "--config", &patch]);
    let output = output.unwrap_or_else(|text| panic!("the emulator does not build: {text}"));
    drop(output);
    program.join("target/release/picket-on-rsemu")
}

fn cargo(directory: &Path, arguments: &[&str]) -> Result<String, String> {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(directory).args(arguments).env_remove("CARGO_TARGET_DIR");
    let output = command.output().map_err(|error| error.to_string())?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    if output.status.success() { Ok(text(&output.stdout)) } else { Err(text(&output.stderr)) }
}

/// Where cargo has unpacked the crate.
fn original(program: &Path) -> PathBuf {
    // What comes over the network is what the lock's checksum names.
    let lock = workspace().join("host-tests/rsemu/Cargo.lock");
    copy(&lock, &program.join("Cargo.lock"), |text| text);
    let described = cargo(program, &["metadata", "--locked", "--format-version", "1"]);
    let described = described.unwrap_or_else(|text| panic!("the emulator's packages: {text}"));
    let described: serde_json::Value = serde_json::from_str(&described).unwrap();
    let packages = described["packages"].as_array().unwrap();
    let rsemu = packages.iter().find(|package| package["name"] == "rsemu").unwrap();
    let manifest = rsemu["manifest_path"].as_str().unwrap();
    Path::new(manifest).parent().unwrap().to_owned()
}

/// Copies the crate's source, each correction made once.
fn correct(from: &Path, to: &Path) {
    copy(&from.join("Cargo.toml"), &to.join("Cargo.toml"), |text| {
        // Its tests, benches and programs stay behind.
        let mut left = false;
        let kept = text.lines().filter(|line| {
            if line.starts_with('[') {
                left = ["[[test]]", "[[bench]]", "[[bin]]", "[[example]]"].contains(line);
            }
            !left
        });
        kept.flat_map(|line| [line, "\n"]).collect()
    });
    let mut folders = vec![PathBuf::from("src"), PathBuf::from("machines")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(from.join(&folder)).unwrap() {
            let path = folder.join(entry.unwrap().file_name());
            if from.join(&path).is_dir() {
                folders.push(path);
                continue;
            }
            fs::create_dir_all(to.join(&folder)).unwrap();
            fs::copy(from.join(&path), to.join(&path)).unwrap();
        }
    }
    for Correction { file, from, to: new } in CORRECTIONS {
        let path = to.join(file);
        copy(&path.clone(), &path, |text| {
            // A register block's access functions come first; its tests may hold the same lines.
            assert!(text.contains(from), "{CRATE}/{file} has changed: {from}");
            text.replacen(from, new, 1)
        });
    }
}

/// Writes a text where it is not the same already.
fn copy(from: &Path, to: &Path, change: impl FnOnce(String) -> String) {
    let text = change(
        fs::read_to_string(from).unwrap_or_else(|error| panic!("{}: {error}", from.display())),
    );
    if fs::read_to_string(to).ok().as_ref() != Some(&text) {
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        fs::write(to, text).unwrap();
    }
}
