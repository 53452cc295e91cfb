//! The two precisions the estimators are evaluated in.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// f32 or f64: the operations the estimators need, with std's meaning.
#[expect(missing_docs, reason = "the names are those of std's f32 and f64")]
pub trait Real:
    Copy
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The nearest value; exact for f64.
    fn of(value: f64) -> Self;
    fn sqrt(self) -> Self;
    fn exp(self) -> Self;
    fn exp_m1(self) -> Self;
    fn ln(self) -> Self;
    fn ln_1p(self) -> Self;
    fn abs(self) -> Self;
    fn is_finite(self) -> bool;
    /// The larger; `self` where they are not ordered.
    fn at_least(self, low: Self) -> Self {
        if low > self { low } else { self }
    }
    /// The smaller; `self` where they are not ordered.
    fn at_most(self, high: Self) -> Self {
        if high < self { high } else { self }
    }
}

macro_rules! real {
    ($float:ty) => {
        impl Real for $float {
            #[inline]
            fn of(value: f64) -> Self {
                value as $float
            }
            #[inline]
            fn sqrt(self) -> Self {
                self.sqrt()
            }
            #[inline]
            fn exp(self) -> Self {
                self.exp()
            }
            #[inline]
            fn exp_m1(self) -> Self {
                self.exp_m1()
            }
            #[inline]
            fn ln(self) -> Self {
                self.ln()
            }
            #[inline]
            fn ln_1p(self) -> Self {
                self.ln_1p()
            }
            #[inline]
            fn abs(self) -> Self {
                self.abs()
            }
            #[inline]
            fn is_finite(self) -> bool {
                self.is_finite()
            }
        }
    };
}

real!(f32);
real!(f64);
