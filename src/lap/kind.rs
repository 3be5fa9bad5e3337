//! Texture types: how a solid texture turns with direction, and how it changes with depth \[LST 3\].

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// The texture types of \[LST 3\]: anisotropy level 0, 1 or 2, then the number of directions of
/// variation, `a` (none) to `d` (three).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum TextureType {
    /// Isotropic: each patch is turned at random.
    Type0,
    /// Along one direction: texture x follows R, each patch is turned about it at random.
    Type1a,
    /// Depth-varying layers: texture y is the depth, each patch is turned about its gradient at random.
    Type1b,
    /// Three different cross-sections: texture x follows R, texture y the depth's gradient.
    Type2a,
    /// As 2a, and texture y *is* the depth.
    Type2b,
    /// Varying along two directions: texture y is the depth, texture x the field `along`.
    Type2c,
    /// Varying along all three directions: the fields `along`, depth and `across` are the mapping.
    Type2d,
}

/// Which inputs a texture type draws on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Inputs {
    /// A depth field: texture y.
    pub depth: bool,
    /// A direction field.
    pub direction: bool,
    /// A scale; the others take theirs from the fields that are given.
    pub scale: bool,
    /// A field that is texture x.
    pub along: bool,
    /// A field that is texture z.
    pub across: bool,
}

impl Inputs {
    /// All of them by name, as the tables of a project file are called, and whether the type draws on it.
    #[must_use]
    pub fn named(self) -> [(&'static str, bool); 5] {
        [
            ("depth", self.depth),
            ("direction", self.direction),
            ("scale", self.scale),
            ("along", self.along),
            ("across", self.across),
        ]
    }
}

impl TextureType {
    /// All types, in order.
    pub const ALL: [Self; 7] =
        [Self::Type0, Self::Type1a, Self::Type1b, Self::Type2a, Self::Type2b, Self::Type2c, Self::Type2d];

    /// The name in \[LST 3\], as on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Type0 => "0",
            Self::Type1a => "1a",
            Self::Type1b => "1b",
            Self::Type2a => "2a",
            Self::Type2b => "2b",
            Self::Type2c => "2c",
            Self::Type2d => "2d",
        }
    }

    /// What it needs; an input that it does not need is refused.
    #[must_use]
    pub fn inputs(self) -> Inputs {
        Inputs {
            depth: !matches!(self, Self::Type0 | Self::Type1a),
            direction: matches!(self, Self::Type1a | Self::Type2a | Self::Type2b),
            scale: matches!(self, Self::Type0 | Self::Type1a | Self::Type2a | Self::Type2c),
            along: matches!(self, Self::Type2c | Self::Type2d),
            across: matches!(self, Self::Type2d),
        }
    }

    /// Which of the texture's coordinates x, y, z *are* fields (`along`, depth, `across`) \[LST 5.2.7\]; the
    /// others are solved for.
    #[must_use]
    pub fn given(self) -> [bool; 3] {
        let needs = self.inputs();
        [needs.along, needs.depth && self != Self::Type2a, needs.across]
    }
}

impl fmt::Display for TextureType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A word that names no texture type.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is no texture type: the types are 0, 1a, 1b, 2a, 2b, 2c and 2d")]
pub struct UnknownType(pub String);

impl FromStr for TextureType {
    type Err = UnknownType;

    fn from_str(word: &str) -> Result<Self, UnknownType> {
        let plain = word.trim().to_ascii_lowercase().replace('-', "");
        Self::ALL.into_iter().find(|t| t.name() == plain).ok_or_else(|| UnknownType(word.to_owned()))
    }
}

impl TryFrom<String> for TextureType {
    type Error = UnknownType;

    fn try_from(word: String) -> Result<Self, UnknownType> {
        word.parse()
    }
}

impl From<TextureType> for String {
    fn from(kind: TextureType) -> Self {
        kind.name().to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip() {
        for t in TextureType::ALL {
            assert_eq!(t.name().parse(), Ok(t));
        }
        assert_eq!("2-B".parse(), Ok(TextureType::Type2b));
        assert!("3".parse::<TextureType>().is_err());
    }
}
