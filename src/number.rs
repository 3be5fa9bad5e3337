//! Numbers in messages and legends.

use std::fmt;

/// A number as people write it: four significant digits, and an exponent only where there is no room without one.
///
/// ```
/// use lapis::number::Short;
/// let shown = [0.0, 99.0, 0.123456, 1234567.0, 1e-7, 1e300].map(|x| Short(x).to_string());
/// assert_eq!(shown, ["0", "99", "0.1235", "1235000", "1e-7", "1e300"]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Short(pub f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let short: f64 = format!("{:.3e}", self.0).parse().unwrap_or(self.0);
        if short != 0.0 && !(1e-4..1e7).contains(&short.abs()) {
            write!(f, "{short:e}")
        } else {
            write!(f, "{short}")
        }
    }
}
