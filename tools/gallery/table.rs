//! Table 1 of the paper, a column of ours beside each of its own.

use std::error::Error;
use std::fmt::Write as _;

use super::Shown;
use super::page::{count, number, wrap};

/// Where the table stands in the README.
const BEGIN: &str = "<!-- Table 1: written by `cargo run --release --example gallery` -->\n";
const END: &str = "<!-- end of Table 1 -->\n";

/// The table, with what its columns mean.
pub(crate) fn table(shown: &[Shown], machine: &str) -> Result<String, Box<dyn Error>> {
    let mut text = String::new();
    wrap(
        &mut text,
        &format!(
            "Table 1 of Takayama et al. 2008 (a notebook with 2.3 GHz and 1 GB of 2008), and in bold Lapis on {machine}. \
             *Design*: the paper's is a person's time, ours what the solvers of the fields take. *Fill*: from the fields \
             to the patches, with what is pasted. *Cut*: the surface alone, without subdividing tetrahedra; beside it \
             ours with all of it, where each piece is a model that can be cut again. Both are means over the project's \
             cuts. *Size*: the filled model with its textures."
        ),
    )?;
    writeln!(
        text,
        "\n| | tetrahedra | design | fill | cut | with subdivision | size |\n|---|---|---|---|---|---|---|"
    )?;
    for one in shown {
        let Some(paper) = &one.model.paper else { continue };
        let spent =
            |name: &str| one.report.seconds.get(name).and_then(serde_json::Value::as_f64).unwrap_or(0.0);
        writeln!(
            text,
            "| {} | {} **{}** | {:.0} s **{} s** | {:.0} s **{} s** | {:.0} ms **{:.1} ms** | **{:.1} ms** | \
             {:.1} MB **{:.1} MB** |",
            one.model.title,
            paper.tetrahedra,
            count(&one.report, "tetrahedra")?,
            paper.design_s,
            short(spent("fields")),
            paper.fill_s,
            short(spent("fill") + spent("paste")),
            paper.cut_ms,
            one.cuts.section_ms,
            one.cuts.cut_ms,
            paper.megabytes,
            one.bytes as f64 / 1e6,
        )?;
    }
    writeln!(
        text,
        "\n| | patches | layers over a tetrahedron | angle to the fields | seams | sharpness | not covered, inverted |\n\
         |---|---|---|---|---|---|---|"
    )?;
    for one in shown.iter().filter(|one| one.model.paper.is_some()) {
        let report = &one.report;
        writeln!(
            text,
            "| {} | {} | {:.1} | {:.1}° | {:.2} % | {:.2} | {}, {} |",
            one.model.title,
            count(report, "patches")?,
            number(report, "layers_mean")?,
            number(report, "angle_mean_deg")?,
            100.0 * number(report, "clump_edge_share")?,
            number(report, "sharpness")?,
            count(report, "uncovered")?,
            count(report, "inverted")?,
        )?;
    }
    Ok(text)
}

/// Seconds with two digits that count.
fn short(seconds: f64) -> String {
    match seconds {
        s if s < 0.1 => format!("{s:.3}"),
        s if s < 10.0 => format!("{s:.2}"),
        s => format!("{s:.1}"),
    }
}

/// The README with the table in its place.
pub(crate) fn into_readme(readme: &str, table: &str) -> Result<String, Box<dyn Error>> {
    let missing = "README.md has no place for the table";
    let (before, rest) = readme.split_once(BEGIN).ok_or(missing)?;
    let (_, after) = rest.split_once(END).ok_or(missing)?;
    Ok(format!("{before}{BEGIN}{table}{END}{after}"))
}
