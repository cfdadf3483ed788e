//! What a method costs: a number that counts the operations made with it.

use num_traits::{Float, Num, NumCast, One, ToPrimitive, Zero};
use picket_dsp::math::scalar::Scalar;
use picket_transform::num_complex::Complex;
use std::cell::Cell;
use std::num::FpCategory;
use std::ops::{Add, Div, Mul, Neg, Rem, Sub};

/// Operations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Additions and subtractions.
    pub additions: u64,
    /// Multiplications.
    pub multiplications: u64,
    /// Divisions.
    pub divisions: u64,
    /// Square roots.
    pub roots: u64,
    /// Sines, cosines, arc tangents and logarithms.
    pub functions: u64,
}

thread_local! {
    static COST: Cell<Cost> = const { Cell::new(Cost {
        additions: 0, multiplications: 0, divisions: 0, roots: 0, functions: 0,
    }) };
}

fn count(change: impl FnOnce(&mut Cost)) {
    COST.with(|cell| {
        let mut cost = cell.get();
        change(&mut cost);
        cell.set(cost);
    });
}

/// What `work` costs.
pub fn cost_of(work: impl FnOnce()) -> Cost {
    COST.with(|cell| cell.set(Cost::default()));
    work();
    COST.with(Cell::get)
}

/// An `f64` whose operations are counted.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Counted(pub f64);

macro_rules! operation {
    ($($trait:ident $method:ident $field:ident;)*) => {$(
        impl $trait for Counted {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                count(|cost| cost.$field += 1);
                Counted(self.0.$method(other.0))
            }
        }
    )*};
}

operation! {
    Add add additions;
    Sub sub additions;
    Mul mul multiplications;
    Div div divisions;
    Rem rem divisions;
}

impl Neg for Counted {
    type Output = Self;
    fn neg(self) -> Self {
        Counted(-self.0)
    }
}

impl Zero for Counted {
    fn zero() -> Self {
        Counted(0.0)
    }
    fn is_zero(&self) -> bool {
        self.0 == 0.0
    }
}

impl One for Counted {
    fn one() -> Self {
        Counted(1.0)
    }
}

impl Num for Counted {
    type FromStrRadixErr = <f64 as Num>::FromStrRadixErr;
    fn from_str_radix(text: &str, radix: u32) -> Result<Self, Self::FromStrRadixErr> {
        f64::from_str_radix(text, radix).map(Counted)
    }
}

impl ToPrimitive for Counted {
    fn to_i64(&self) -> Option<i64> {
        self.0.to_i64()
    }
    fn to_u64(&self) -> Option<u64> {
        self.0.to_u64()
    }
    fn to_f64(&self) -> Option<f64> {
        Some(self.0)
    }
}

impl NumCast for Counted {
    fn from<T: ToPrimitive>(x: T) -> Option<Self> {
        x.to_f64().map(Counted)
    }
}

macro_rules! float {
    (constants $($constant:ident)*; questions $($question:ident)*; free $($free:ident)*;
        pairs $($pair:ident)*; functions $($function:ident)*; of_two $($two:ident)*;) => {
        impl Float for Counted {
            $(fn $constant() -> Self { Counted(<f64 as Float>::$constant()) })*
            $(fn $question(self) -> bool { Float::$question(self.0) })*
            $(fn $free(self) -> Self { Counted(Float::$free(self.0)) })*
            $(fn $pair(self, other: Self) -> Self { Counted(Float::$pair(self.0, other.0)) })*
            $(fn $function(self) -> Self {
                count(|cost| cost.functions += 1);
                Counted(Float::$function(self.0))
            })*
            $(fn $two(self, other: Self) -> Self {
                count(|cost| cost.functions += 1);
                Counted(Float::$two(self.0, other.0))
            })*
            fn classify(self) -> FpCategory {
                self.0.classify()
            }
            fn mul_add(self, a: Self, b: Self) -> Self {
                self * a + b
            }
            fn recip(self) -> Self {
                Counted(1.0) / self
            }
            fn powi(self, n: i32) -> Self {
                count(|cost| cost.multiplications += n.unsigned_abs().max(1).ilog2() as u64);
                Counted(self.0.powi(n))
            }
            fn sqrt(self) -> Self {
                count(|cost| cost.roots += 1);
                Counted(self.0.sqrt())
            }
            fn sin_cos(self) -> (Self, Self) {
                (self.sin(), self.cos())
            }
            fn integer_decode(self) -> (u64, i16, i8) {
                Float::integer_decode(self.0)
            }
        }
    };
}

float! {
    constants nan infinity neg_infinity neg_zero min_value min_positive_value max_value epsilon;
    questions is_nan is_infinite is_finite is_normal is_sign_positive is_sign_negative;
    free floor ceil round trunc fract abs signum;
    pairs max min;
    functions exp exp2 ln log2 log10 cbrt sin cos tan asin acos atan exp_m1 ln_1p sinh cosh tanh asinh acosh atanh;
    of_two powf log hypot atan2 abs_sub;
}

impl Scalar for Counted {
    fn new(x: f64) -> Self {
        Counted(x)
    }
    fn from_i32(x: i32) -> Self {
        Counted(x.into())
    }
    fn from_u64(x: u64) -> Self {
        Counted(x as f64)
    }
    fn two_to(exponent: i32) -> Self {
        Counted(f64::two_to(exponent))
    }
    fn root(self) -> Self {
        self.sqrt()
    }
    fn wide(self) -> f64 {
        self.0
    }
    fn unit(turns: Self) -> Complex<Self> {
        count(|cost| {
            cost.multiplications += 1;
            cost.functions += 2;
        });
        let Complex { re, im } = f64::unit(turns.0);
        Complex::new(Counted(re), Counted(im))
    }
    fn angle(z: Complex<Self>) -> Self {
        count(|cost| cost.functions += 1);
        Counted(f64::angle(Complex::new(z.re.0, z.im.0)))
    }
    fn arctan(self) -> Self {
        count(|cost| cost.functions += 1);
        Counted(self.0.arctan())
    }
    fn log_e(self) -> Self {
        count(|cost| cost.functions += 1);
        Counted(self.0.log_e())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn operations_are_counted() {
        let cost = cost_of(|| {
            let z = Complex::new(Counted(3.0), Counted(4.0));
            assert_eq!(z.norm_sqr().sqrt() / Counted(5.0), Counted(1.0));
        });
        let expected =
            Cost { additions: 1, multiplications: 2, divisions: 1, roots: 1, functions: 0 };
        assert_eq!(cost, expected);
    }
}
