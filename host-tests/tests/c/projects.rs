//! The package in strangers' projects: CMake, pkg-config, Arduino, PlatformIO, Zephyr.

use super::{CROSS, M4F, dist, emulated, needs, said, source, temporary};
use host_tests::needed;
use picket_host::c::{Core, package};
use picket_host::emulator::Footprint;
use picket_host::toolchain::environment;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

/// A stranger's project: it knows the folder of the package and nothing else.
const PROJECT: &str = r#"cmake_minimum_required(VERSION 3.16)
project(app C)
WAY
add_executable(app app.c)
target_link_libraries(app PRIVATE picket::picket)
if(NOT CMAKE_CROSSCOMPILING)
  target_link_libraries(app PRIVATE m)
endif()
"#;

#[test]
fn a_strangers_cmake_project_links_it() {
    needs("cmake", "cmake");
    let dist = dist();
    let ways = [
        ("folder", format!("add_subdirectory({} picket)", dist.display())),
        ("package", "find_package(picket CONFIG REQUIRED)".to_owned()),
    ];
    for (name, way) in ways {
        let place = temporary(&format!("cmake-{name}"));
        fs::write(place.join("CMakeLists.txt"), PROJECT.replace("WAY", &way)).unwrap();
        fs::copy(dist.join("examples/tone/tone.c"), place.join("app.c")).unwrap();
        let build = place.join("build");
        let mut command = Command::new("cmake");
        command.arg("-S").arg(&place).arg("-B").arg(&build);
        said(command.arg(format!("-Dpicket_DIR={}", dist.join("cmake").display())));
        said(Command::new("cmake").arg("--build").arg(&build));
        let out = said(&mut Command::new(build.join("app")));
        assert!(out.starts_with("1000.0") && out.contains(" Hz: good. "), "{out}");
    }
    needs(CROSS, "gcc-arm-none-eabi");
    let place = temporary("cmake-cross");
    fs::write(
        place.join("CMakeLists.txt"),
        PROJECT.replace("WAY", "find_package(picket CONFIG REQUIRED)"),
    )
    .unwrap();
    let [start, single] =
        ["start.c", "single.c"].map(|name| fs::read_to_string(source(name)).unwrap());
    fs::write(place.join("start.h"), start).unwrap();
    fs::write(place.join("app.c"), format!("#include \"start.h\"\n{single}")).unwrap();
    let toolchain = format!(
        "set(CMAKE_SYSTEM_NAME Generic)\nset(CMAKE_C_COMPILER {CROSS})\nset(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)\n\
         set(CMAKE_C_FLAGS_INIT \"{} -O2 -ffreestanding -fno-tree-loop-distribute-patterns -ffunction-sections\")\n\
         set(CMAKE_EXE_LINKER_FLAGS_INIT \"-nostdlib -nostartfiles -Wl,--gc-sections -T{}\")\n",
        M4F.0.join(" "),
        source("mps2.ld").display()
    );
    fs::write(place.join("arm.cmake"), toolchain).unwrap();
    let build = place.join("build");
    let mut command = Command::new("cmake");
    command.arg("-S").arg(&place).arg("-B").arg(&build);
    command.arg(format!("-DCMAKE_TOOLCHAIN_FILE={}", place.join("arm.cmake").display()));
    said(command.arg(format!("-Dpicket_DIR={}", dist.join("cmake").display())));
    said(Command::new("cmake").arg("--build").arg(&build));
    emulated(M4F.2, &build.join("app"));
}

#[test]
fn pkg_config_finds_the_hosts_archive() {
    let dist = dist();
    needs("pkg-config", "pkg-config");
    needs("gcc", "gcc");
    let words = said(
        Command::new("pkg-config")
            .env("PKG_CONFIG_PATH", dist)
            .args(["--cflags", "--libs", "picket"]),
    );
    let out = temporary("pkg-config").join("tone");
    let mut command = Command::new("gcc");
    command.arg(dist.join("examples/tone/tone.c")).args(words.split_whitespace()).arg("-lm");
    said(command.arg("-o").arg(&out));
    assert!(said(&mut Command::new(out)).contains("Hz: good. "));
}

/// The sketch of the package on the Teensy 4's own core, which PJRC publishes.
#[test]
#[ignore = "needs a clone that is named: PICKET_TEENSY, of github.com/PaulStoffregen/cores"]
fn named_the_sketch_links_with_the_teensys_core() {
    let cores = std::env::var_os("PICKET_TEENSY").map(PathBuf::from);
    let cores = cores.expect("PICKET_TEENSY names a clone of github.com/PaulStoffregen/cores");
    needs(CROSS, "gcc-arm-none-eabi");
    let place = temporary("teensy");
    needed(package(&Core::M7.places()[..1], &place.join("picket")));
    let core = cores.join("teensy4");
    let flags = "-mcpu=cortex-m7 -mthumb -mfloat-abi=hard -mfpu=fpv5-d16 -O2 -ffunction-sections -fdata-sections -nostdlib -w \
                 -D__IMXRT1062__ -DTEENSYDUINO=159 -DARDUINO=10819 -DARDUINO_TEENSY41 -DF_CPU=600000000 -DUSB_SERIAL \
                 -DLAYOUT_US_ENGLISH";
    let plus = "-std=gnu++17 -fno-exceptions -fpermissive -fno-rtti -fno-threadsafe-statics -felide-constructors";
    let mut objects = Vec::new();
    let sketch = place.join("doppler.cpp");
    fs::copy(place.join("picket/examples/doppler/doppler.ino"), &sketch).unwrap();
    let files = fs::read_dir(&core).unwrap().map(|entry| entry.unwrap().path());
    for file in files.chain([sketch]) {
        let end = file.extension().and_then(|end| end.to_str()).unwrap_or_default();
        let (compiler, more) = match end {
            "c" | "S" => (CROSS, ""),
            "cpp" => ("arm-none-eabi-g++", plus),
            _ => continue,
        };
        let object = place.join(file.file_name().unwrap()).with_extension(format!("{end}.o"));
        let mut command = Command::new(compiler);
        command.args(flags.split_whitespace()).args(more.split_whitespace());
        command.arg("-I").arg(&core).arg("-I").arg(place.join("picket/src"));
        said(command.arg("-c").arg(&file).arg("-o").arg(&object));
        objects.push(object);
    }
    let elf = place.join("doppler.elf");
    let mut command = Command::new("arm-none-eabi-g++");
    command.args([
        "-O2",
        "-Wl,--gc-sections,--relax",
        "-mthumb",
        "-mcpu=cortex-m7",
        "-mfloat-abi=hard",
        "-mfpu=fpv5-d16",
    ]);
    command.arg(format!("-T{}", core.join("imxrt1062_t41.ld").display()));
    command.args(["--specs=nano.specs", "--specs=nosys.specs"]).args(&objects);
    command.arg("-L").arg(place.join("picket/src/imxrt1062/fpv5-d16-hard"));
    said(command.args(["-lpicket", "-lm", "-lstdc++", "-o"]).arg(&elf));
    println!("the Teensy 4's image: {:?}", Footprint::from_elf(&elf).unwrap());
}

/// What the sketch asks of Arduino's interface, and no more, for a machine without a core of it.
const ARDUINO: &str = r#"#include <stddef.h>
#include <stdint.h>
enum { A0 = 14 };
uint32_t micros();
int analogRead(int pin);
void analogReadResolution(int bits);
struct Port {
  void begin(long baud);
  void print(double value, int digits = 2);
  void print(const char *text);
  void println(double value, int digits = 2);
  void println(const char *text);
};
extern Port Serial;
"#;

/// A board behind it: a converter that sees a target at 2 m/s, and a clock that the program's questions drive.
const BOARD: &str = r#"#include "Arduino.h"
extern "C" void say(const char *text);
void setup();
void loop();
Port Serial;
static uint32_t now_us, phase, state = 1, blocks;
uint32_t micros() { return now_us += 5; }
void analogReadResolution(int) {}
int analogRead(int) {
  phase += 0x0A4E2C43;
  state = state * 1664525u + 1013904223u;
  int32_t x = (int32_t)phase >> 16, y = 4 * x * (32768 - (x < 0 ? -x : x)) / 32768 >> 5;
  blocks++;
  return 2048 + y / 2 + (int)(state >> 27);
}
void Port::begin(long) {}
void Port::print(const char *text) { say(text); }
void Port::println(const char *text) { say(text), say("\n"); }
void Port::print(double value, int) {
  char text[16];
  int32_t thousandths = (int32_t)(value * 1000.0 + 0.5), place = 10000;
  char *to = text;
  for (; place > 0; place /= 10) {
    if (place == 100) *to++ = '.';
    *to++ = (char)('0' + thousandths / place % 10);
  }
  *to = 0;
  say(text);
}
void Port::println(double value, int digits) { print(value, digits), say("\n"); }
extern "C" int main() {
  setup();
  while (blocks < 3 * 1024) loop();
  return 0;
}
"#;

/// The sketch of the package through the interface of Arduino that it uses, on an emulated M4F.
#[test]
fn the_sketch_runs_on_arduinos_interface() {
    let compiler = "arm-none-eabi-g++";
    needs(compiler, "gcc-arm-none-eabi");
    let dist = dist();
    let place = temporary("arduino");
    fs::write(place.join("Arduino.h"), ARDUINO).unwrap();
    fs::write(place.join("board.cpp"), BOARD).unwrap();
    let sketch = place.join("doppler.cpp");
    fs::copy(dist.join("examples/doppler/doppler.ino"), &sketch).unwrap();
    let start = place.join("start.o");
    let mut command = Command::new(CROSS);
    command.args(M4F.0).args(["-std=c99", "-O2", "-fno-tree-loop-distribute-patterns", "-c"]);
    said(command.arg(source("start.c")).arg("-o").arg(&start));
    let image = place.join("doppler.elf");
    let mut command = Command::new(compiler);
    command.args(M4F.0).args(["-std=gnu++17", "-O2", "-fno-exceptions", "-fno-rtti", "-Wall"]);
    // The compiler may be here without a C library.
    command.args([
        "-ffreestanding",
        "-nostdlib",
        "-nostartfiles",
        "-Wl,--gc-sections,-z,noexecstack",
    ]);
    command.arg("-I").arg(&place).arg("-I").arg(dist.join("src")).arg("-T").arg(source("mps2.ld"));
    command.arg(&sketch).arg(place.join("board.cpp")).arg(&start);
    command.arg(dist.join("src").join(M4F.1).join("libpicket.a")).args(["-lgcc", "-o"]).arg(&image);
    said(&mut command);
    let text = emulated(M4F.2, &image);
    // 322 Hz at 10.525 GHz are 4.586 m/s.
    let answers: Vec<&str> = text.lines().map(str::trim).collect();
    assert_eq!(answers.len(), 3, "{text}");
    assert!(
        answers.iter().all(|line| line.starts_with("04.58") && line.contains(" m/s +- ")),
        "{text}"
    );
}

/// A platform for PlatformIO that needs no package of its registry: a core, and the compiler of this machine.
const PLATFORM: [(&str, &str); 4] = [
    (
        "platform/platform.json",
        r#"{"name": "bare", "title": "Bare", "description": "A core", "version": "1.0.0", "packages": {}}"#,
    ),
    (
        "platform/boards/mps2.json",
        r#"{"name": "MPS2", "vendor": "Arm", "url": "", "frameworks": [], "build": {"cpu": "cortex-m4", "mcu": "mps2"},
            "upload": {"maximum_size": 4194304, "maximum_ram_size": 4194304}}"#,
    ),
    (
        "platform/builder/main.py",
        r#"from SCons.Script import Default, DefaultEnvironment

env = DefaultEnvironment()
tools = {"CC": "gcc", "CXX": "g++", "AS": "gcc", "LINK": "gcc", "AR": "ar", "RANLIB": "ranlib"}
env.Replace(PROGNAME="program", PROGSUFFIX=".elf", **{tool: "arm-none-eabi-" + name for tool, name in tools.items()})
core = "CORE".split()
env.Append(CCFLAGS=core + "-O2 -ffreestanding -fno-tree-loop-distribute-patterns -ffunction-sections".split())
env.Append(LINKFLAGS=core + "-nostdlib -nostartfiles -Wl,--gc-sections -TSCRIPT".split())
Default(env.BuildProgram())
"#,
    ),
    (
        "platformio.ini",
        "[env:mps2]\nplatform = symlink://PLACE/platform\nboard = mps2\nlib_deps = symlink://PACKAGE\n",
    ),
];

/// SCons as PlatformIO keeps it, which comes from PyPI here.
const SCONS: [(&str, &str); 3] = [
    ("package.json", r#"{"name": "tool-scons", "version": "VERSION", "description": "SCons"}"#),
    (
        ".piopm",
        r#"{"type": "tool", "name": "tool-scons", "version": "VERSION",
            "spec": {"owner": "platformio", "id": null, "name": "tool-scons", "requirements": null, "uri": null}}"#,
    ),
    ("scons.py", "import SCons.Script\nSCons.Script.main()\n"),
];

/// PlatformIO itself reads the package's library.json and its script, and links the archive.
#[test]
fn platformio_links_it() {
    needs(CROSS, "gcc-arm-none-eabi");
    let dist = dist();
    let place = temporary("platformio");
    // PlatformIO 6.1 asks for SCons 4.8.1 as 4.40801.0, 6.2 for 4.11.1.
    let packages = ["platformio==6.2.*", "scons==4.11.1"];
    let programs = needed(environment(&place.join("python"), &packages));
    let write = |file: PathBuf, text: String| {
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(file, text).unwrap();
    };
    for (name, text) in SCONS {
        let file = place.join("core/packages/tool-scons").join(name);
        write(file, text.replace("VERSION", "4.41101.0"));
    }
    for (name, text) in PLATFORM {
        let text = text.replace("CORE", &M4F.0.join(" "));
        let text = text.replace("SCRIPT", source("mps2.ld").to_str().unwrap());
        let text = text.replace("PLACE", place.to_str().unwrap());
        write(place.join(name), text.replace("PACKAGE", dist.to_str().unwrap()));
    }
    for name in ["start.c", "single.c"] {
        write(place.join("src").join(name), fs::read_to_string(source(name)).unwrap());
    }
    let mut command = Command::new(programs.join("pio"));
    command.env("PLATFORMIO_CORE_DIR", place.join("core")).args(["run", "-d"]).arg(&place);
    said(command.env("PLATFORMIO_SETTING_ENABLE_TELEMETRY", "no"));
    emulated(M4F.2, &place.join(".pio/build/mps2/program.elf"));
}

/// Zephyr is too large for a test. Its two functions that the module calls say here what they are told.
const ZEPHYR: &str = r#"function(zephyr_include_directories)
  message(STATUS "includes ${ARGN}")
endfunction()
function(zephyr_library_import name file)
  if(NOT EXISTS ${file})
    message(FATAL_ERROR "there is no ${file}")
  endif()
  message(STATUS "imports ${name} ${file}")
endfunction()
include(MODULE/zephyr/CMakeLists.txt)
"#;

#[test]
fn zephyrs_module_finds_the_archive() {
    needs("cmake", "cmake");
    let dist = dist();
    let place = temporary("zephyr");
    let script = place.join("zephyr.cmake");
    fs::write(&script, ZEPHYR.replace("MODULE", dist.to_str().unwrap())).unwrap();
    let told = |options: &[&str]| {
        let mut command = Command::new("cmake");
        command.args(options.iter().map(|option| format!("-DCONFIG_{option}=y")));
        said(command.arg("-P").arg(&script))
    };
    let out = told(&["PICKET", "CPU_CORTEX_M4", "FP_HARDABI"]);
    assert!(
        out.contains(&format!("imports picket {}", dist.join("src").join(M4F.1).display())),
        "{out}"
    );
    assert!(out.contains("includes ") && told(&["CPU_CORTEX_M4"]).is_empty());
    // Its words for the configuration, by the reader that Zephyr's own is a copy of.
    let programs = needed(environment(&place.join("python"), &["kconfiglib"]));
    let module = dist.join("zephyr/Kconfig");
    let all = "config CPU_CORTEX_M4\n\tbool\n\tdefault y\n";
    fs::write(place.join("Kconfig"), format!("{all}source \"{}\"\n", module.display())).unwrap();
    let ask = "import kconfiglib, sys; k = kconfiglib.Kconfig(sys.argv[1], warn_to_stderr=False); \
               k.load_config(sys.argv[2]); print(k.syms['PICKET'].str_value, k.warnings)";
    let mut command = Command::new(programs.join("python"));
    command.args(["-c", ask]).arg(place.join("Kconfig"));
    let answer = said(command.arg(dist.join("examples/zephyr/prj.conf")));
    assert!(answer.starts_with("y "), "{answer}");
}
