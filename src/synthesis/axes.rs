//! Axes of a volume, and how its slices lie in a picture.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// An axis of a volume; as a slice's name, the axis that the slice is perpendicular to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// The first axis, fastest in memory.
    X,
    /// The second axis, along which depth runs.
    Y,
    /// The third axis.
    Z,
}

impl Axis {
    /// All three, in order.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// Its number: 0, 1, 2.
    #[must_use]
    pub fn index(self) -> usize {
        self as usize
    }

    /// The axis that runs to the right in a picture of a slice perpendicular to this one: ⟂x shows z to the right
    /// and y down; ⟂y x right, z down; ⟂z x right, y down.
    #[must_use]
    pub fn right(self) -> Self {
        match self {
            Self::X => Self::Z,
            Self::Y | Self::Z => Self::X,
        }
    }

    /// The axis that runs down in such a picture; see [`Axis::right`].
    #[must_use]
    pub fn down(self) -> Self {
        match self {
            Self::X | Self::Z => Self::Y,
            Self::Y => Self::Z,
        }
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(["x", "y", "z"][self.index()])
    }
}

impl FromStr for Axis {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "x" => Ok(Self::X),
            "y" => Ok(Self::Y),
            "z" => Ok(Self::Z),
            other => Err(format!("'{other}' is no axis: it must be x, y or z")),
        }
    }
}

/// Some of the three axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Axes(pub [bool; 3]);

impl Axes {
    /// All three.
    pub const ALL: Self = Self([true; 3]);
}

impl fmt::Display for Axes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 == [false; 3] {
            return f.write_str("none");
        }
        Axis::ALL.iter().filter(|a| self.0[a.index()]).try_for_each(|a| write!(f, "{a}"))
    }
}

impl FromStr for Axes {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut axes = [false; 3];
        if text == "none" {
            return Ok(Self(axes));
        }
        for letter in text.chars() {
            let axis = letter.to_string().parse::<Axis>().map_err(|_| {
                format!(
                    "'{text}' names no axes: write the letters of those that are meant, as in xz, or none"
                )
            })?;
            axes[axis.index()] = true;
        }
        if axes == [false; 3] {
            return Err("no axis is named: write their letters, as in xz, or none".to_owned());
        }
        Ok(Self(axes))
    }
}

impl TryFrom<String> for Axes {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Axes> for String {
    fn from(axes: Axes) -> Self {
        axes.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_survive_the_round_trip() {
        for bits in 0..8 {
            let axes = Axes([bits & 1 != 0, bits & 2 != 0, bits & 4 != 0]);
            assert_eq!(axes.to_string().parse(), Ok(axes));
        }
        assert!("xw".parse::<Axes>().is_err() && "".parse::<Axes>().is_err() && "Y".parse::<Axis>().is_err());
    }

    #[test]
    fn a_slice_shows_the_two_other_axes() {
        for axis in Axis::ALL {
            let mut all = [axis, axis.right(), axis.down()];
            all.sort_unstable();
            assert_eq!(all, Axis::ALL);
        }
    }
}
