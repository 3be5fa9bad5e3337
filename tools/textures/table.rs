//! The measures as Markdown.

use std::fmt::Write as _;

use lapis::assess::Directions;

use super::Made;

/// The table of the photographs, and that of the ablations.
pub(crate) fn tables(made: &[Made], ablated: &[Made]) -> String {
    let mut text = String::new();
    for (title, list) in [("Photographs", made), ("Ablations", ablated)] {
        if list.is_empty() {
            continue;
        }
        // Writing to a string cannot fail.
        let _ = write!(text, "{title}\n\n{HEAD}");
        for one in list {
            let _ = writeln!(text, "{}", row(one));
        }
        text.push('\n');
    }
    text
}

const HEAD: &str = "\
| | entropy | coverage | distance over floor, fine | half | quarter | oblique, fine | colour distance | gradient ratio | wrap seam | copies | s |
|---|---|---|---|---|---|---|---|---|---|---|---|
";

/// One row.
pub(crate) fn row(one: &Made) -> String {
    let (report, found) = (&one.report, &one.found);
    let ratio = |level: usize| mean(axes(&found.ratio).map(|d| d.and_then(|d| d.get(level).copied())));
    let gradient = &found.gradient_ratio;
    let seam = &found.wrap_seam;
    let seam = [seam.x, seam.y, seam.z].into_iter().flatten().fold(f64::NAN, f64::max);
    format!(
        "| {} | {:.4} | {:.3} | {:.2} | {:.2} | {:.2} | {:.2} | {:.3} | {:.2} | {seam:.2} | {:.3} | {:.0} |",
        one.name,
        report.position_entropy,
        report.position_coverage,
        ratio(0),
        ratio(1),
        ratio(2),
        found.ratio.oblique.first().copied().unwrap_or(f64::NAN),
        found.colour_distance,
        mean([gradient.x, gradient.y, gradient.z]),
        found.copied,
        one.seconds,
    )
}

fn axes(d: &Directions) -> [Option<&Vec<f64>>; 3] {
    [d.x.as_ref(), d.y.as_ref(), d.z.as_ref()]
}

fn mean(values: [Option<f64>; 3]) -> f64 {
    let there: Vec<f64> = values.into_iter().flatten().collect();
    there.iter().sum::<f64>() / there.len() as f64
}
