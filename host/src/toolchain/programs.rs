//! Other people's programs: those on the path, else out of their packages.

use super::apt;
use super::error::ToolError;
use super::process::on_path;
use super::unpacked::Unpacked;
use std::path::PathBuf;

/// A compiler with the source of its library and its linter, and a linker for firmware and for WebAssembly.
pub(super) static RUST: Unpacked = Unpacked {
    what: "Rust for firmware and page",
    folder: "rust",
    packages: &["rustc-web", "rust-web-src", "rust-web-clippy", "lld-{llvm}"],
    programs: &[
        ("rustc", "usr/bin/rustc"),
        ("clippy-driver", "usr/bin/clippy-driver"),
        ("ld.lld", "usr/lib/llvm-{llvm}/bin/ld.lld"),
        ("wasm-ld", "usr/lib/llvm-{llvm}/bin/wasm-ld"),
    ],
};

/// The others.
static OTHERS: [Unpacked; 9] = [
    Unpacked {
        what: "the emulator of Cortex-M",
        folder: "qemu-arm",
        packages: &["qemu-system-arm"],
        programs: &[("qemu-system-arm", "usr/bin/qemu-system-arm")],
    },
    Unpacked {
        what: "the emulator of RISC-V",
        folder: "qemu-misc",
        packages: &["qemu-system-misc"],
        programs: &[("qemu-system-riscv32", "usr/bin/qemu-system-riscv32")],
    },
    Unpacked {
        what: "the binutils for Cortex-M",
        folder: "binutils-arm",
        packages: &["binutils-arm-none-eabi"],
        programs: &[
            ("arm-none-eabi-ar", "usr/bin/arm-none-eabi-ar"),
            ("arm-none-eabi-as", "usr/bin/arm-none-eabi-as"),
            ("arm-none-eabi-ld", "usr/bin/arm-none-eabi-ld"),
            ("arm-none-eabi-objcopy", "usr/bin/arm-none-eabi-objcopy"),
        ],
    },
    Unpacked {
        what: "the C compiler for Cortex-M",
        folder: "gcc-arm",
        // Without a library for C, which is eight times as large, and which CMSIS-DSP is not linked with.
        packages: &["gcc-arm-none-eabi"],
        programs: &[
            ("arm-none-eabi-gcc", "usr/bin/arm-none-eabi-gcc"),
            ("arm-none-eabi-g++", "usr/bin/arm-none-eabi-g++"),
        ],
    },
    Unpacked {
        what: "Node.js",
        folder: "node",
        packages: &["nodejs", "npm"],
        programs: &[("node", "usr/bin/node"), ("npm", "usr/share/nodejs/npm/bin/npm-cli.js")],
    },
    Unpacked {
        what: "a browser",
        folder: "chromium",
        packages: &["chromium"],
        programs: &[("chromium", "usr/lib/chromium/chromium")],
    },
    Unpacked {
        what: "CMake",
        folder: "cmake",
        packages: &["cmake"],
        programs: &[("cmake", "usr/bin/cmake")],
    },
    Unpacked {
        what: "clang",
        folder: "clang",
        packages: &["clang"],
        programs: &[("clang", "usr/bin/clang"), ("clang++", "usr/bin/clang++")],
    },
    Unpacked {
        what: "pkg-config",
        folder: "pkg-config",
        packages: &["pkgconf", "pkgconf-bin"],
        programs: &[("pkg-config", "usr/bin/pkgconf")],
    },
];

/// The path of a program: the one on `PATH`, else the one of its package, which is downloaded and unpacked where it is missing.
///
/// # Errors
/// It can be had from nowhere: the cause, and the command that mends it.
pub fn program(name: &str) -> Result<PathBuf, ToolError> {
    if let Some(path) = on_path(name) {
        return Ok(path);
    }
    let has = |package: &&Unpacked| package.programs.iter().any(|(program, _)| *program == name);
    match OTHERS.iter().find(has) {
        Some(package) => package.program(name),
        None => Err(apt::missing(name, &[name], None)),
    }
}

/// The path of a browser that scripts can drive.
///
/// # Errors
/// The errors of [`program`].
pub fn browser() -> Result<PathBuf, ToolError> {
    const OTHERS: [&str; 3] = ["chromium-browser", "google-chrome", "google-chrome-stable"];
    let other = on_path("chromium").or_else(|| OTHERS.iter().find_map(|name| on_path(name)));
    other.map_or_else(|| program("chromium"), Ok)
}

/// The path of `qemu-system-arm`.
///
/// # Errors
/// The errors of [`program`].
pub fn qemu() -> Result<PathBuf, ToolError> {
    program("qemu-system-arm")
}

/// The path of `qemu-system-riscv32`.
///
/// # Errors
/// The errors of [`program`].
pub fn qemu_riscv32() -> Result<PathBuf, ToolError> {
    program("qemu-system-riscv32")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_program_is_in_one_package() {
        let mut names: Vec<&str> = OTHERS
            .iter()
            .flat_map(|package| package.programs.iter().map(|(name, _)| *name))
            .collect();
        let all = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), all);
    }

    /// By name alone: it downloads several hundred megabytes.
    #[test]
    #[ignore = "downloads every package"]
    fn every_program_starts_from_its_package() {
        let packages = OTHERS.iter().chain([&RUST]);
        let failures: Vec<String> = packages
            .flat_map(|package| package.programs.iter().map(move |(name, _)| package.program(name)))
            .filter_map(|program| program.err().map(|error| error.to_string()))
            .collect();
        assert!(failures.is_empty(), "{}", failures.join("\n"));
    }
}
