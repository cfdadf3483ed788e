//! CMSIS-DSP by Arm's compiler, which its figures are counted with: its sources are those of a package on PyPI.

use super::error::{ToolError, io_error};
use super::process::Show;
use super::process::{capture, locked};
use super::programs;
use super::{Target, target_dir};
use crate::cli::quoted;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What the package is called, and the version of CMSIS-DSP that it holds.
pub const PACKAGE: &str = "cmsisdsp 1.10.3";
const ARCHIVE: &str = "cmsisdsp.tar.gz";
const FOLDER: &str = "cmsisdsp-1.10.3";
const ADDRESS: &str = "https://files.pythonhosted.org/packages/2c/ec/0decbb48985d2eb98739a9bbf4ba090278cc492a7c1a5d5b907e8baf67b5/cmsisdsp-1.10.3.tar.gz";
const SHA256: &str = "307d32298faa7c58db912851027fce35f886fec7eb1a27c4b309ce1a97f47519";

const COMPILER: &str = "arm-none-eabi-gcc";

/// What the transforms, the magnitudes and the largest of them consist of.
const SOURCES: [&str; 28] = [
    "TransformFunctions/arm_rfft_q15",
    "TransformFunctions/arm_rfft_init_q15",
    "TransformFunctions/arm_cfft_q15",
    "TransformFunctions/arm_cfft_init_q15",
    "TransformFunctions/arm_cfft_radix4_q15",
    "TransformFunctions/arm_rfft_q31",
    "TransformFunctions/arm_rfft_init_q31",
    "TransformFunctions/arm_cfft_q31",
    "TransformFunctions/arm_cfft_init_q31",
    "TransformFunctions/arm_cfft_radix4_q31",
    "TransformFunctions/arm_rfft_fast_f32",
    "TransformFunctions/arm_rfft_fast_init_f32",
    "TransformFunctions/arm_cfft_f32",
    "TransformFunctions/arm_cfft_init_f32",
    "TransformFunctions/arm_cfft_radix8_f32",
    "TransformFunctions/arm_bitreversal",
    "TransformFunctions/arm_bitreversal2",
    "CommonTables/arm_common_tables",
    "CommonTables/arm_const_structs",
    "CommonTables/arm_mve_tables",
    "BasicMathFunctions/arm_shift_q15",
    "BasicMathFunctions/arm_shift_q31",
    "ComplexMathFunctions/arm_cmplx_mag_squared_q15",
    "ComplexMathFunctions/arm_cmplx_mag_squared_q31",
    "ComplexMathFunctions/arm_cmplx_mag_squared_f32",
    "StatisticsFunctions/arm_max_q15",
    "StatisticsFunctions/arm_max_q31",
    "StatisticsFunctions/arm_max_f32",
];

/// The compiler's options for a core, and where its program and its memory begin on the emulated board.
fn options(target: Target) -> Option<(&'static [&'static str], [u32; 2])> {
    match target {
        Target::M4f => {
            Some((&["-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard"], [0, 0x2000_0000]))
        }
        Target::M55 => {
            Some((&["-mcpu=cortex-m55", "-mfloat-abi=hard"], [0x1000_0000, 0x3000_0000]))
        }
        _ => None,
    }
}

/// Builds the program `lab/cmsis/bench.c` for records of `n` samples, which lie `header` bytes into the capture, by one of
/// the library's kinds of numbers: `Q15`, `Q31` or `F32`. `None` for a core that the library's figures are not counted on.
///
/// # Errors
/// Compiler or sources cannot be had.
pub fn cmsis(
    target: Target,
    numbers: &str,
    n: usize,
    header: usize,
) -> Result<Option<PathBuf>, ToolError> {
    let Some((core, [program, memory])) = options(target) else { return Ok(None) };
    let home = target_dir().join("cmsis");
    fs::create_dir_all(&home).map_err(io_error(home.display()))?;
    let _lock = locked(&home.join("build.lock"))?;
    let compiler = programs::program(COMPILER)?;
    let library = sources(&home)?;
    let own = super::workspace().join("lab/cmsis");
    let gcc = || {
        let mut command = Command::new(&compiler);
        command.args(core).args([
            "-O3",
            "-w",
            "-DARM_MATH_LOOPUNROLL",
            "-ffunction-sections",
            "-fdata-sections",
        ]);
        for include in
            [own.join("include"), library.join("Include"), library.join("PrivateInclude")]
        {
            command.arg("-I").arg(include);
        }
        command
    };
    let objects = home.join(target.name());
    fs::create_dir_all(&objects).map_err(io_error(objects.display()))?;
    let mut files = Vec::new();
    for source in SOURCES {
        let name = source.rsplit('/').next().unwrap_or(source);
        let object = objects.join(name).with_extension("o");
        if !object.exists() {
            // Whole or not at all.
            let part = object.with_extension("part");
            let mut command = gcc();
            let file = library.join("Source").join(source).with_extension("c");
            command.arg("-c").arg(file).arg("-o").arg(&part);
            built(command, name)?;
            fs::rename(&part, &object).map_err(io_error(object.display()))?;
        }
        files.push(object);
    }
    let image = objects.join(format!("{numbers}-{n}.elf"));
    let mut command = gcc();
    command.args(["-nostartfiles", "-nostdlib", "-Wl,--gc-sections"]);
    command.args([format!("-D{numbers}"), format!("-DN={n}"), format!("-DHEADER={header}")]);
    command.arg(format!("-Wl,--defsym=origin={program:#x},--defsym=memory={memory:#x}"));
    command.arg("-T").arg(own.join("bench.ld")).arg(own.join("bench.c"));
    command.args(files).args(["-lgcc", "-o"]).arg(&image);
    built(command, "bench.c")?;
    Ok(Some(image))
}

fn built(command: Command, what: &str) -> Result<(), ToolError> {
    match capture(command, Show::Nothing)? {
        (true, _) => Ok(()),
        (false, output) => Err(ToolError::Build { bin: format!("CMSIS-DSP's {what}"), output }),
    }
}

/// The library's sources, fetched once.
fn sources(home: &Path) -> Result<PathBuf, ToolError> {
    let folder = home.join(FOLDER);
    if folder.join("Source").is_dir() {
        return Ok(folder);
    }
    // In the folder itself: its own name, whatever it is, comes into no shell.
    let fetch = format!("curl -fsSL {ADDRESS} -o {ARCHIVE}");
    let check = format!("echo {SHA256}  {ARCHIVE} | sha256sum --check --status");
    let unpack = format!("tar -xzf {ARCHIVE}");
    for step in [fetch, check, unpack] {
        let mut command = Command::new("sh");
        command.args(["-c", &step]).current_dir(home);
        let (ok, output) = capture(command, Show::Nothing)?;
        if !ok {
            let reason = output.lines().last().map(str::to_owned);
            let command = format!("cd {} && {step}", quoted(&home.display().to_string()));
            return Err(ToolError::Missing { what: PACKAGE.into(), command, reason });
        }
    }
    Ok(folder)
}
