//! An instruction of Armv6-M or Armv7E-M, as far as its timing goes, read from a disassembly.

/// How an address is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// A register and a number.
    Plain,
    /// Two registers.
    Index,
    /// A register that changes with it.
    Update,
}

/// What takes its own time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One cycle.
    Other,
    /// Loads a word or less.
    Load(Access),
    /// Stores a word or less.
    Store(Access),
    /// Loads or stores this many words.
    Words(u8),
    /// Loads or stores a float.
    FloatMemory,
    /// Arithmetic of floats in one cycle.
    Float,
    /// A float product and a sum.
    FloatSum,
    /// Divides floats, or takes a root.
    FloatDivision,
    /// Moves two registers at once between the units.
    TwoRegisters,
    /// Divides integers.
    Division,
    /// A product and a sum.
    Sum,
    /// A product of 64 bits.
    Long,
    /// A product of 64 bits and a sum.
    LongSum,
    /// Jumps by a table.
    Table,
    /// Makes the next instructions conditional.
    IfThen,
    /// Waits for memory, or touches special registers.
    System,
}

/// An instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// Where it lies.
    pub address: u32,
    /// Whether it has 32 bits.
    pub wide: bool,
    /// What it is.
    pub kind: Kind,
    /// Whether it calls a function by a direct address.
    pub links: bool,
    /// Whether it always leaves.
    pub jumps: bool,
    /// The integer registers that it writes, a bit each.
    pub writes: u32,
    /// The integer registers that make its address.
    pub address_of: u32,
    /// The floating-point registers that it writes.
    pub floats: u64,
    /// The floating-point registers that it reads, but for the sum that a product is added to.
    pub reads_floats: u64,
    /// Whether a branch's target is known late.
    pub late: bool,
    /// The register that it copies to itself: a mark.
    pub mark: Option<u8>,
}

impl Step {
    /// Reads a line as QEMU writes it: `0x0000d4a8:  b580       push     {r7, lr}`.
    pub fn read(line: &str) -> Option<Self> {
        let (address, rest) = line.strip_prefix("0x")?.split_once(':')?;
        let address = u32::from_str_radix(address, 16).ok()?;
        let mut words = rest.split_whitespace();
        let code = |text: &&str| text.len() == 4 && u16::from_str_radix(text, 16).is_ok();
        words.next().filter(code)?;
        let mut name = words.next()?;
        // No instruction's name has four hexadecimal digits and nothing else, but `fadd` and the like, which these cores have not.
        let wide = code(&name);
        if wide {
            name = words.next()?;
        }
        let operands = words.collect::<Vec<_>>().join(" ");
        Some(Self::of(address, wide, name, &operands))
    }

    fn of(address: u32, wide: bool, name: &str, operands: &str) -> Self {
        let name = name.trim_end_matches(".w").trim_end_matches(".n");
        let kind = kind(name, operands);
        let (before, within) = operands.split_once('[').unwrap_or((operands, ""));
        let first = operands.split(',').next().unwrap_or("").trim();
        let (memory, float) = (
            matches!(kind, Kind::Load(_) | Kind::Store(_) | Kind::Words(_) | Kind::FloatMemory),
            name.starts_with('v'),
        );
        let address_of = match (memory, within.is_empty()) {
            (false, _) => 0,
            (true, false) => registers(within),
            (true, true) => registers(first),
        };
        let stores = matches!(kind, Kind::Store(_)) || name.starts_with("st");
        let compares = ["cmp", "cmn", "tst", "teq"].iter().any(|head| name.starts_with(head));
        let writes = match (compares || stores || (float && memory), kind) {
            (true, _) => 0,
            (_, Kind::Load(_) | Kind::Words(_)) => registers(before),
            (_, Kind::Long | Kind::LongSum) => {
                registers(&operands.splitn(3, ',').take(2).collect::<Vec<_>>().join(","))
            }
            _ => registers(first),
        };
        let (target, sources) = operands.split_once(',').unwrap_or((operands, ""));
        let (floats, reads_floats) = match (float && !memory, name.starts_with("vcmp")) {
            (false, _) => {
                (0, if float && name.starts_with("vst") { float_registers(before) } else { 0 })
            }
            (true, true) => (0, float_registers(operands)),
            (true, false) => (float_registers(target), float_registers(sources)),
        };
        let pops = registers(before) & 1 << 15 != 0
            && matches!(kind, Kind::Words(_) | Kind::Load(_))
            && !stores;
        let indirect = name.starts_with("bx") || name.starts_with("blx");
        let late = pops || indirect || kind == Kind::Table;
        let mark = match (name, operands) {
            ("mov", "r8, r8") => Some(8),
            ("mov", "sb, sb" | "r9, r9") => Some(9),
            _ => None,
        };
        Self {
            address,
            wide,
            kind,
            links: name == "bl",
            jumps: matches!(name, "b" | "bl" | "bx" | "blx") || late,
            writes,
            address_of,
            floats,
            reads_floats,
            late,
            mark,
        }
    }

    /// Words that it loads or stores, if it is of those that take several.
    pub fn words(&self) -> u64 {
        if let Kind::Words(count) = self.kind { count.into() } else { 0 }
    }

    /// Whether it accesses memory.
    pub fn is_memory(&self) -> bool {
        matches!(self.kind, Kind::Load(_) | Kind::Store(_) | Kind::Words(_) | Kind::FloatMemory)
    }

    /// Whether the floating-point unit takes part.
    pub fn is_float(&self) -> bool {
        matches!(
            self.kind,
            Kind::Float
                | Kind::FloatSum
                | Kind::FloatDivision
                | Kind::FloatMemory
                | Kind::TwoRegisters
        )
    }

    /// Whether it computes with floats.
    pub fn is_arithmetic(&self) -> bool {
        matches!(self.kind, Kind::Float | Kind::FloatSum)
    }

    /// Behind it.
    pub fn end(&self) -> u32 {
        self.address.wrapping_add(if self.wide { 4 } else { 2 })
    }
}

fn kind(name: &str, operands: &str) -> Kind {
    let is = |heads: &[&str]| heads.iter().any(|head| name.starts_with(head));
    let single = || {
        let inside = operands.split_once('[').map_or("", |(_, inside)| inside);
        let (address, behind) = inside.split_once(']').unwrap_or((inside, ""));
        match (address.split_once(','), behind.is_empty()) {
            (_, false) => Access::Update,
            (Some((_, second)), _) if !second.trim_start().starts_with('#') => Access::Index,
            _ => Access::Plain,
        }
    };
    let listed = || Kind::Words(listed(operands));
    if is(&["vldr", "vstr"]) {
        if operands.starts_with('d') { Kind::Words(2) } else { Kind::FloatMemory }
    } else if is(&["vldm", "vstm", "vpush", "vpop"]) || is(&["ldm", "stm", "push", "pop"]) {
        listed()
    } else if is(&["vdiv", "vsqrt"]) {
        Kind::FloatDivision
    } else if is(&["vmla", "vmls", "vnml", "vfm", "vfnm"]) {
        Kind::FloatSum
    } else if name.starts_with("vmov") && operands.matches(',').count() > 1 {
        Kind::TwoRegisters
    } else if name.starts_with('v') {
        Kind::Float
    } else if is(&["ldrd", "strd"]) {
        Kind::Words(2)
    } else if is(&["ldr"]) {
        Kind::Load(single())
    } else if is(&["str"]) {
        Kind::Store(single())
    } else if is(&["sdiv", "udiv"]) {
        Kind::Division
    } else if is(&["mla", "mls"]) {
        Kind::Sum
    } else if is(&["smlal", "umlal", "umaal"]) {
        Kind::LongSum
    } else if is(&["smull", "umull"]) {
        Kind::Long
    } else if is(&["tbb", "tbh"]) {
        Kind::Table
    } else if is(&["it"]) {
        Kind::IfThen
    } else if is(&["dmb", "dsb", "isb", "mrs", "msr"]) {
        Kind::System
    } else {
        Kind::Other
    }
}

/// The words of a list of registers, in which `s0-s3` is four and a `d` is two.
fn listed(operands: &str) -> u8 {
    let inside =
        operands.split_once('{').map_or("", |(_, inside)| inside).trim_end_matches(['}', ' ']);
    let words = |name: &str| if name.trim().starts_with('d') { 2 } else { 1 };
    let count = |part: &str| match part.split_once('-') {
        Some((from, to)) => {
            let number = |name: &str| {
                name.trim().trim_start_matches(['r', 's', 'd']).parse::<u8>().unwrap_or(0)
            };
            (number(to).saturating_sub(number(from)) + 1) * words(from)
        }
        None => words(part),
    };
    inside.split(',').map(count).sum()
}

/// The integer registers in a text, a bit each.
fn registers(text: &str) -> u32 {
    let number = |word: &str| match word {
        "sb" => Some(9),
        "sl" => Some(10),
        "fp" => Some(11),
        "ip" => Some(12),
        "sp" => Some(13),
        "lr" => Some(14),
        "pc" => Some(15),
        _ => word.strip_prefix('r')?.parse().ok().filter(|&number: &u32| number < 16),
    };
    words(text).filter_map(number).fold(0, |set, number| set | 1 << number)
}

/// The single floating-point registers in a text, a bit each.
fn float_registers(text: &str) -> u64 {
    let number =
        |word: &str| word.strip_prefix('s')?.parse().ok().filter(|&number: &u32| number < 32);
    words(text).filter_map(number).fold(0, |set, number| set | 1 << number)
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(line: &str) -> Step {
        Step::read(line).unwrap()
    }

    #[test]
    fn lines_of_a_disassembly() {
        let load = step("0x0000d0de:  f8d0 7000  ldr.w    r7, [r0, ip, lsl #2]");
        assert_eq!((load.address, load.wide, load.end()), (0xD0DE, true, 0xD0E2));
        assert_eq!(
            (load.kind, load.writes, load.address_of),
            (Kind::Load(Access::Index), 1 << 7, 1 | 1 << 12)
        );
        let update = step("0x00000000:  f85d 7b04  ldr      r7, [sp], #4");
        assert_eq!((update.kind, update.address_of), (Kind::Load(Access::Update), 1 << 13));
        assert_eq!(
            step("0x00000000:  f84d 7d04  str      r7, [sp, #-4]!").kind,
            Kind::Store(Access::Update)
        );
        let popped = step("0x00000000:  e8bd 8ff0  pop.w    {r4, r5, r6, r7, r8, sb, sl, fp, pc}");
        assert_eq!((popped.words(), popped.late, popped.jumps), (9, true, true));
        assert_eq!(step("0x00000000:  ed2d 8b04  vpush    {d8, d9}").words(), 4);
        assert_eq!(step("0x00000000:  ecb1 8a04  vldmia   r1!, {s16-s19}").words(), 4);
        let sum = step("0x00000000:  ee03 4a20  vmla.f32 s8, s6, s1");
        assert_eq!(
            (sum.kind, sum.floats, sum.reads_floats),
            (Kind::FloatSum, 1 << 8, 1 << 6 | 1 << 1)
        );
        let branch = step("0x00000000:  d1fc  bne #0x108");
        assert_eq!((branch.kind, branch.jumps, branch.late), (Kind::Other, false, false));
        assert!(step("0x00000000:  4770  bx lr").late);
        assert_eq!(step("0x00000000:  f3c0 0007  ubfx r0, r0, #0, #8").kind, Kind::Other);
        assert_eq!(step("0x00000000:  fbc0 0102  smlal r0, r1, r0, r2").writes, 3);
        assert_eq!(
            [
                step("0x00000000:  46c0  mov r8, r8").mark,
                step("0x00000000:  46c9  mov sb, sb").mark
            ],
            [Some(8), Some(9)]
        );
        assert_eq!(Step::read("Trace 0: 0x7f00 [0/0/0/0] main"), None);
        assert_eq!(Step::read("0x00000100:"), None);
    }
}
