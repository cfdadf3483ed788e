//! The parts of a butterfly of radix 4 that all passes share.

/// x (cos - j sin) / 2 rounded, in place: $factor is packed as `cos | -sin << 16`, the rounding is
/// in $half.
macro_rules! turn {
    ($x:literal, $factor:literal, $free:literal, $half:literal) => {
        concat!(
            "smlsd ",
            $free,
            ", ",
            $x,
            ", ",
            $factor,
            ", ",
            $half,
            "\n",
            "smladx ",
            $x,
            ", ",
            $x,
            ", ",
            $factor,
            ", ",
            $half,
            "\n",
            "pkhtb ",
            $x,
            ", ",
            $x,
            ", ",
            $free,
            ", asr #16\n",
        )
    };
}

/// The sums of a butterfly in place, from leg 0, halved, in $a and legs 1, 2, 3, turned, in $b, $c,
/// $d. They give points 0 $c, 1 $free, 2 $d, 3 $a, and $b is free.
macro_rules! sums {
    ($a:literal, $b:literal, $c:literal, $d:literal, $free:literal) => {
        concat!(
            "sadd16 ",
            $free,
            ", ",
            $b,
            ", ",
            $d,
            "\n ssub16 ",
            $b,
            ", ",
            $b,
            ", ",
            $d,
            "\n",
            "sadd16 ",
            $d,
            ", ",
            $a,
            ", ",
            $c,
            "\n ssub16 ",
            $a,
            ", ",
            $a,
            ", ",
            $c,
            "\n",
            ".if {twice}\n",
            "shadd16 ",
            $c,
            ", ",
            $d,
            ", ",
            $free,
            "\n shsub16 ",
            $d,
            ", ",
            $d,
            ", ",
            $free,
            "\n",
            "shsax ",
            $free,
            ", ",
            $a,
            ", ",
            $b,
            "\n shasx ",
            $a,
            ", ",
            $a,
            ", ",
            $b,
            "\n",
            ".else\n",
            "sadd16 ",
            $c,
            ", ",
            $d,
            ", ",
            $free,
            "\n ssub16 ",
            $d,
            ", ",
            $d,
            ", ",
            $free,
            "\n",
            "ssax ",
            $free,
            ", ",
            $a,
            ", ",
            $b,
            "\n sasx ",
            $a,
            ", ",
            $a,
            ", ",
            $b,
            "\n",
            ".endif\n",
        )
    };
}

/// Loads the rounding of products into r5 and the rounding of halves into r6.
macro_rules! rounding {
    () => {
        lines!("mov r5, #0x8000", "mov r6, #0x10001")
    };
}

/// Halves all legs of a butterfly without factors.
macro_rules! halves {
    () => {
        lines!(
            "shadd16 r7, r7, r6",
            "shadd16 r8, r8, r6",
            "shadd16 r9, r9, r6",
            "shadd16 r10, r10, r6"
        )
    };
}
