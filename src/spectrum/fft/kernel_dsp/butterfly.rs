//! Parts of a radix-4 butterfly, as text for the loops of the passes.

/// Stores the point `$x`, `$y` at `$base` and `$at`. STRD takes three cycles of a
/// Cortex-M4, two STR take two (TRM, 3.3.1 and 3.3.2).
macro_rules! store {
    ($x:literal, $y:literal, $base:literal, $at:literal) => {
        concat!(
            "str ", $x, ", [", $base, ", #", $at, "]\n str ", $y, ", [", $base, ", #", $at,
            "+4]\n",
        )
    };
}

/// Loads a point stored by `store!`, from beyond the reach of LDRD. Two LDR take three cycles, as LDRD does.
macro_rules! load {
    ($x:literal, $y:literal, $base:literal, $at:literal) => {
        concat!(
            "ldr ", $x, ", [", $base, ", #", $at, "]\n ldr ", $y, ", [", $base, ", #", $at,
            "+4]\n",
        )
    };
}

/// Stores the point `$x`, `$y` at `$to`, and advances `$to` to the next point.
macro_rules! store_and_go {
    ($x:literal, $y:literal, $to:literal) => {
        concat!("str ", $y, ", [", $to, ", #4]\n str ", $x, ", [", $to, "], #8\n")
    };
}

/// Sum r5, r8 and difference r12, r6 of leg 1 in r12, r6 and leg 3 in `$re`, `$im`.
macro_rules! sum_outer_legs {
    ($re:literal, $im:literal) => {
        concat!(
            "add r5, r12, ",
            $re,
            "\n sub r12, r12, ",
            $re,
            "\n add r8, r6, ",
            $im,
            "\n sub r6, r6, ",
            $im,
            "\n"
        )
    };
}

/// The four sums of a butterfly: of the sum and difference above, leg 2 in r10, r9, and leg 0, not
/// halved, in r7, lr. They give points 0 (lr, r5), 1 (r8, r6), 2 (r11, r7), 3 (r10, r9).
macro_rules! sum_all_legs {
    () => {
        "add r11, r10, r7, asr #1
         rsb r10, r10, r7, asr #1
         add r7, r9, lr, asr #1
         rsb r9, r9, lr, asr #1
         add lr, r11, r5
         sub r11, r11, r5
         add r5, r7, r8
         sub r7, r7, r8
         add r8, r10, r6
         sub r10, r10, r6
         sub r6, r9, r12
         add r9, r9, r12\n"
    };
}

/// `integer::turn` of r5, r6 and of r5, r7, which are legs 1 and 3; then their sum r5, r8 and difference r12, r6. The factors are in `$one`
/// and `$three`. The caller supplies the loads, and may load a factor between them.
macro_rules! outer_legs {
    ($load1:expr, $one:literal, $load3:expr, $three:literal) => {
        concat!(
            $load1, // r5, r6
            "smulwb r12, r5, ",
            $one,
            "\n smulwt r8, r6, ",
            $one,
            "\n sub r12, r12, r8\n",
            "smulwb r6, r6, ",
            $one,
            "\n smlawt r6, r5, ",
            $one,
            ", r6\n",
            $load3, // r5, r7
            "smulwb r8, r5, ",
            $three,
            "\n smulwt r9, r7, ",
            $three,
            "\n sub r8, r8, r9\n",
            "smulwb r7, r7, ",
            $three,
            "\n smlawt r7, r5, ",
            $three,
            ", r7\n",
            sum_outer_legs!("r8", "r7"),
        )
    };
}

/// `integer::turn` of r7, r9: leg 2 in r10, r9. Uses `$spare`.
macro_rules! middle_leg {
    ($load2:expr, $two:literal, $spare:literal) => {
        concat!(
            $load2, // r7, r9
            "smulwb r10, r7, ",
            $two,
            "\n smulwt ",
            $spare,
            ", r9, ",
            $two,
            "\n sub r10, r10, ",
            $spare,
            "\n smulwb r9, r9, ",
            $two,
            "\n smlawt r9, r7, ",
            $two,
            ", r9\n",
        )
    };
}

/// `integer::turn_finely` of $x, $y by the factor in $cos, $sin, to $re, $im.
macro_rules! turn_finely {
    ($re:literal, $im:literal, $x:literal, $y:literal, $cos:literal, $sin:literal) => {
        concat!(
            "smmul ",
            $re,
            ", ",
            $x,
            ", ",
            $cos,
            "\n smmla ",
            $re,
            ", ",
            $y,
            ", ",
            $sin,
            ", ",
            $re,
            "\n",
            "smmul ",
            $im,
            ", ",
            $y,
            ", ",
            $cos,
            "\n smmls ",
            $im,
            ", ",
            $x,
            ", ",
            $sin,
            ", ",
            $im,
            "\n",
        )
    };
}

/// Legs 1 to 3 with factors of 1, in the registers of [`outer_legs`] and [`middle_leg`].
macro_rules! plain_legs {
    ($load1:expr, $load3:expr, $load2:expr) => {
        concat!(
            $load1, // r7, r9
            $load3, // r10, r11
            "asr r7, r7, #1\n asr r9, r9, #1\n",
            "add r5, r7, r10, asr #1\n sub r12, r7, r10, asr #1\n",
            "add r8, r9, r11, asr #1\n sub r6, r9, r11, asr #1\n",
            $load2, // r10, r9
            "asr r10, r10, #1\n asr r9, r9, #1\n",
        )
    };
}

/// The first butterfly of four legs at r0 to r3; advances the four pointers.
macro_rules! plain_of_legs {
    () => {
        concat!(
            plain_legs!("ldrd r7, r9, [r1]\n", "ldrd r10, r11, [r3]\n", "ldrd r10, r9, [r2]\n"),
            "ldrd r7, lr, [r0]\n",
            sum_all_legs!(),
            store_to_legs!(),
        )
    };
}

/// Stores the result of [`sum_all_legs`] to four legs at r0 to r3, and advances the four pointers.
macro_rules! store_to_legs {
    () => {
        concat!(
            store_and_go!("lr", "r5", "r0"),
            store_and_go!("r8", "r6", "r1"),
            store_and_go!("r11", "r7", "r2"),
            store_and_go!("r10", "r9", "r3"),
        )
    };
}
