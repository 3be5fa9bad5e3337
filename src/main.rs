//! The `lapis` program.

fn main() {}
