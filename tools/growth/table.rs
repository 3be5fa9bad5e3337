//! The results as Markdown.

use std::fmt::Write;
use std::fs;

use serde_json::Value;

/// One size, and TetGen alone on it.
type Column = (Value, Option<Value>);

/// A table with a column a size, and how each stage grows from one size to the next.
///
/// `busy`: the seconds of the stages are those of the processor, without TetGen's process.
pub(crate) fn markdown(columns: &[Column], threads: usize, busy: bool) -> String {
    let mut text = format!("{}, {threads} threads; cuts on one.\n\n", machine());
    let number = |v: &Value, name: &str| v[name].as_f64().unwrap_or(f64::NAN);
    let mut row = |name: &str, cell: &dyn Fn(&Column) -> String| {
        // Writing to a string cannot fail.
        let _ = write!(text, "| {name} |");
        for column in columns {
            let _ = write!(text, " {} |", cell(column));
        }
        text.push('\n');
    };
    row("tetrahedra", &|c| whole(number(&c.0, "tetrahedra")));
    row("---", &|_| "--:".to_owned());
    row("triangles of the surface", &|c| whole(number(&c.0, "surface_triangles")));
    row("patches", &|c| whole(number(&c.0, "patches")));
    row("tetrahedra a patch", &|c| whole(number(&c.0, "tetrahedra_per_patch")));
    row("runs of TetGen", &|c| whole(number(&c.0, "tetgen_runs")));
    let names: Vec<String> = columns
        .first()
        .and_then(|c| c.0["stages"].as_array())
        .map(|s| s.iter().filter_map(|s| s["name"].as_str().map(str::to_owned)).collect())
        .unwrap_or_default();
    let stage = |c: &Column, name: &str, what: &str| -> f64 {
        let stages = c.0["stages"].as_array();
        let found = stages.and_then(|s| s.iter().find(|s| s["name"] == name));
        let what = if busy && what == "seconds" { "busy" } else { what };
        found.and_then(|s| s[what].as_f64()).unwrap_or(f64::NAN)
    };
    for name in &names {
        row(&format!("{name}, s"), &|c| seconds(stage(c, name, "seconds")));
    }
    row("**fields and fill, s**", &|c| {
        format!("**{}**", seconds(stage(c, "fields", "seconds") + stage(c, "fill", "seconds")))
    });
    row("TetGen alone, s", &|c| c.1.as_ref().map_or_else(String::new, |a| seconds(number(a, "seconds"))));
    row("its tetrahedra", &|c| c.1.as_ref().map_or_else(String::new, |a| whole(number(a, "tetrahedra"))));
    for name in ["tetrahedralise", "fields", "fill", "write", "cut, plane"] {
        row(&format!("peak of {name}, MiB"), &|c| whole(stage(c, name, "peak_kib") / 1024.0));
    }
    row("peak of TetGen's process, MiB", &|c| whole(number(&c.0, "helper_peak_kib") / 1024.0));
    row("model, MB", &|c| format!("{:.1}", number(&c.0, "bytes") / 1e6));

    text.push_str("\nHow the seconds grow from size to size, as a power of the number of tetrahedra:\n\n");
    let steps: Vec<&[Column]> = columns.windows(2).collect();
    let mut row = |name: &str, cell: &dyn Fn(&[Column]) -> String| {
        let _ = write!(text, "| {name} |");
        for step in &steps {
            let _ = write!(text, " {} |", cell(step));
        }
        text.push('\n');
    };
    row("to", &|s| whole(number(&s[1].0, "tetrahedra")));
    row("---", &|_| "--:".to_owned());
    for name in &names {
        row(name, &|s| {
            let grown = stage(&s[1], name, "seconds") / stage(&s[0], name, "seconds");
            let more = number(&s[1].0, "tetrahedra") / number(&s[0].0, "tetrahedra");
            format!("{:.2}", grown.ln() / more.ln())
        });
    }
    text
}

/// A whole number with its thousands apart.
fn whole(x: f64) -> String {
    if !x.is_finite() {
        return String::new();
    }
    let digits = format!("{x:.0}");
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i) % 3 == 0 {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Three digits of a time.
fn seconds(x: f64) -> String {
    if !x.is_finite() {
        String::new()
    } else if x < 0.1 {
        format!("{x:.4}")
    } else if x < 10.0 {
        format!("{x:.2}")
    } else {
        format!("{x:.1}")
    }
}

/// The processor, its cores and the memory, where Linux tells.
fn machine() -> String {
    let after = |file: &str, key: &str| {
        let text = fs::read_to_string(file).ok()?;
        let line = text.lines().find(|l| l.starts_with(key))?;
        Some(line.split(':').nth(1)?.trim().to_owned())
    };
    let model = after("/proc/cpuinfo", "model name").unwrap_or_else(|| "an unknown processor".to_owned());
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let memory = after("/proc/meminfo", "MemTotal")
        .and_then(|m| m.trim_end_matches(" kB").parse::<f64>().ok())
        .map_or_else(String::new, |kib| format!(", {:.0} GiB of memory", kib / 1024.0 / 1024.0));
    format!("{model}, {cores} cores{memory}")
}
