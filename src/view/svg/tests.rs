use glam::DVec2;

use super::super::{StrokeFile, ViewFileProblem};
use super::*;

fn draw(inside: &str) -> Drawing {
    read(inside).unwrap_or_else(|e| panic!("{e}\n{inside}"))
}

fn read(inside: &str) -> Result<Drawing, ViewFileProblem> {
    Drawing::from_svg(&format!(
        "<?xml version=\"1.0\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 200 100\">{inside}</svg>"
    ))
}

fn fault(inside: &str) -> String {
    read(inside).unwrap_err().to_string()
}

fn points(drawing: &Drawing) -> Vec<[f64; 2]> {
    let round = |x: f64| (x * 1e6).round() / 1e6;
    drawing.lines.iter().flat_map(|l| &l.points).map(|p| [round(p.x), round(p.y)]).collect()
}

fn path(d: &str) -> Drawing {
    draw(&format!("<path d=\"{d}\"/>"))
}

#[test]
fn straight_commands_absolute_and_relative() {
    let corner = vec![[0.05, 0.1], [0.5, 0.1], [0.5, 0.6]];
    for d in [
        "M10 10 L100 10 L100 60",
        "M10,10H100V60",
        "m10 10 90 0 0 50",
        "m10 10h90v50",
        "M1e1,1.0E1 100,10 100,60",
        "M10 10l90 0,0 50",
    ] {
        let drawing = path(d);
        assert_eq!(points(&drawing), corner, "{d}");
        assert!(!drawing.lines[0].closed);
        assert_eq!(drawing.aspect, 2.0);
    }
    let closed = path("M10 10 H100 V60 z");
    assert!(closed.lines[0].closed);
    assert_eq!(points(&closed), corner);
    let back = path("M10 10 H100 V60 L10 10");
    assert!(back.lines[0].closed);
}

#[test]
fn a_path_of_several_parts_is_several_lines() {
    let drawing = path("M0 0 L20 0 M0 50 l20 0 z l10 10");
    let lengths: Vec<usize> = drawing.lines.iter().map(|l| l.points.len()).collect();
    assert_eq!(lengths, [2, 2, 2]);
    assert_eq!(drawing.lines.iter().map(|l| l.closed).collect::<Vec<_>>(), [false, true, false]);
    // After z a path goes on from where the part began.
    assert_eq!(drawing.lines[2].points[0], DVec2::new(0.0, 0.5));
}

/// Points on the unit-square picture's curve must be near it, and chords short of it by the flatness only.
fn near(drawing: &Drawing, curve: impl Fn(f64) -> DVec2) {
    let size = DVec2::new(200.0, 100.0);
    let line = &drawing.lines[0].points;
    assert!(line.len() > 4 && line.len() < 500, "{}", line.len());
    for k in 0..=100 {
        let p = curve(f64::from(k) / 100.0) / size;
        let distance = line.windows(2).map(|w| {
            let d = w[1] - w[0];
            let s = ((p - w[0]).dot(d) / d.length_squared()).clamp(0.0, 1.0);
            (w[0] + d * s).distance(p)
        });
        assert!(distance.fold(f64::INFINITY, f64::min) < 2e-4, "{p}");
    }
}

#[test]
fn curves_are_followed() {
    let cubic = |t: f64| {
        let [a, b, c, d] = [[10.0, 10.0], [60.0, 10.0], [100.0, 40.0], [150.0, 90.0]].map(DVec2::from);
        let s = 1.0 - t;
        a * s * s * s + b * 3.0 * s * s * t + c * 3.0 * s * t * t + d * t * t * t
    };
    near(&path("M10 10 C60 10 100 40 150 90"), cubic);
    near(&path("m10 10 c50 0 90 30 140 80"), cubic);
    let quadratic = |t: f64| {
        let [a, b, c] = [[10.0, 10.0], [60.0, 90.0], [150.0, 10.0]].map(DVec2::from);
        a * (1.0 - t).powi(2) + b * 2.0 * t * (1.0 - t) + c * t * t
    };
    near(&path("M10 10 Q60 90 150 10"), quadratic);
    near(&path("M10 10 q50 80 140 0"), quadratic);
    // A smooth join repeats the control point mirrored: S and T against their long forms.
    assert_eq!(
        points(&path("M10 50 C10 10 50 10 60 50 S110 90 120 50")),
        points(&path("M10 50 C10 10 50 10 60 50 C70 90 110 90 120 50"))
    );
    assert_eq!(points(&path("M10 50 Q30 0 50 50 t40 0")), points(&path("M10 50 Q30 0 50 50 Q70 100 90 50")));
    // An upper half circle of radius 40 around 100, 50.
    let arc = |t: f64| {
        let (s, c) = (std::f64::consts::PI * t).sin_cos();
        DVec2::new(100.0 - 40.0 * c, 50.0 - 40.0 * s)
    };
    near(&path("M60 50 A40 40 0 0 1 140 50"), arc);
    near(&path("M60 50 a40,40 0 01 80,0"), arc);
    near(&draw("<circle cx=\"100\" cy=\"50\" r=\"40\"/>"), arc);
    near(&draw("<ellipse cx=\"100\" cy=\"50\" rx=\"40\" ry=\"40\"/>"), arc);
    assert!(draw("<circle cx=\"100\" cy=\"50\" r=\"40\"/>").lines[0].closed);
}

#[test]
fn lines_polylines_and_polygons() {
    assert_eq!(points(&draw("<line x1=\"20\" y1=\"10\" x2=\"2cm\" y2=\"50\"/>"))[0], [0.1, 0.1]);
    assert_eq!(
        points(&draw("<polyline points=\"0,0 100,50\n200 100\"/>")),
        [[0.0, 0.0], [0.5, 0.5], [1.0, 1.0]]
    );
    let polygon = draw("<polygon points=\"0 0 100,0-20-30\"/>");
    assert!(polygon.lines[0].closed);
    assert_eq!(points(&polygon)[2], [-0.1, -0.3]);
}

#[test]
fn transforms_apply_from_the_inside_out() {
    let inside = "<g transform=\"translate(100 50)\"><g transform=\"rotate(90) scale(2)\"><path d=\"M0 0 H10 V5\" \
        transform=\"matrix(1 0 0 1 5 0)\"/></g></g>";
    assert_eq!(points(&draw(inside)), [[0.5, 0.6], [0.5, 0.8], [0.45, 0.8]]);
}

#[test]
fn the_frame_is_the_picture_that_is_drawn_over() {
    let size = |head: &str, inside: &str| {
        Drawing::from_svg(&format!("<svg xmlns=\"http://www.w3.org/2000/svg\" {head}>{inside}</svg>"))
    };
    let line = "<path d=\"M10 20 H60\"/>";
    let by_size = size("width=\"100px\" height=\"50\"", line).unwrap();
    assert_eq!(points(&by_size), [[0.1, 0.4], [0.6, 0.4]]);
    assert_eq!(by_size.aspect, 2.0);
    let by_box = size("width=\"100mm\" height=\"100mm\" viewBox=\"-10 0 100 40\"", line).unwrap();
    assert_eq!(points(&by_box), [[0.2, 0.5], [0.7, 0.5]]);
    // A page of another shape than its viewBox shows more than that; the page is the picture.
    assert_eq!(by_box.aspect, 1.0);
    let wide = |ratio: &str| {
        let head = format!("width=\"80\" height=\"40\" viewBox=\"0 0 100 100\" {ratio}");
        let drawing = size(&head, line).unwrap();
        (points(&drawing), drawing.aspect)
    };
    assert_eq!(wide(""), (vec![[0.3, 0.2], [0.55, 0.2]], 2.0));
    assert_eq!(wide("preserveAspectRatio=\"xMinYMid\""), (vec![[0.05, 0.2], [0.3, 0.2]], 2.0));
    assert_eq!(wide("preserveAspectRatio=\"xMidYMin slice\""), (vec![[0.1, 0.4], [0.6, 0.4]], 2.0));
    assert_eq!(wide("preserveAspectRatio=\"none\""), (vec![[0.1, 0.2], [0.6, 0.2]], 2.0));
    assert!(size("width=\"8\" height=\"4\" viewBox=\"0 0 1 1\" preserveAspectRatio=\"odd\"", line).is_err());
    // A picture on a page, moved and scaled: fractions are the picture's.
    let image = "<g transform=\"translate(5 10)\"><image x=\"0\" y=\"0\" width=\"20\" height=\"10\" \
        transform=\"scale(5)\" href=\"kiwi.png\"/></g>";
    let by_image = size("viewBox=\"0 0 210 297\"", &format!("{image}{line}")).unwrap();
    assert_eq!(points(&by_image), [[0.05, 0.2], [0.55, 0.2]]);
    assert!((by_image.aspect - 2.0).abs() < 1e-12);
    // Of two, none is the picture.
    let two = size("viewBox=\"0 0 100 100\"", &format!("{image}{image}{line}")).unwrap();
    assert_eq!(points(&two), [[0.1, 0.2], [0.6, 0.2]]);
    for head in ["", "width=\"100%\" height=\"100%\"", "width=\"10\"", "viewBox=\"0 0 1e-320 1\""] {
        let error = size(head, line).unwrap_err().to_string();
        assert!(error.contains("viewBox"), "{head}: {error}");
    }
}

#[test]
fn what_does_not_show_is_passed_over() {
    let drawing = draw(
        "<defs><path d=\"M0 0 H9\"/></defs><rect width=\"200\" height=\"100\"/><clipPath><path d=\"M0 0 H9\"/></clipPath>\
         <g display=\"none\"><path d=\"M0 0 H9\"/></g><g style=\"opacity:1; display : none\"><path d=\"M0 0 H9\"/></g>\
         <!-- a note --><text>hello</text><path/><path d=\"\"/><circle r=\"0\"/><path id=\"a\" d=\"M0 0 H9\"/>",
    );
    assert_eq!(drawing.lines.len(), 1);
    assert_eq!(drawing.lines[0].ids, ["a"]);
}

#[test]
fn what_a_style_sheet_hides_is_passed_over() {
    let line = |attributes: &str| format!("<path d=\"M0 0 H9\" {attributes}/>");
    let shown = |sheet: &str, inside: &str| {
        let all = format!("<style>{sheet}</style>{inside}{}", line("id=\"last\""));
        draw(&all).lines.len() - 1
    };
    let class = line("class=\"st0 b\"");
    for (sheet, inside, count) in [
        (".st0{display:none}", class.clone(), 0),
        ("/* .st0{} */ .a, path.b { Display : None; fill: red }", class.clone(), 0),
        ("<![CDATA[ #x{visibility:hidden} ]]>", line("id=\"x\""), 0),
        (".st0{opacity:0}", class.clone(), 0),
        (".st0{opacity:0.5}", class.clone(), 1),
        (".st1{display:none} path.st1{}", class.clone(), 1),
        ("@import 'x'; @media print { .st0 { display: none } }", class.clone(), 1),
        ("g .st0{display:none}", format!("<g>{class}</g>{class}"), 1),
        ("g > .st0{display:none} .st0:hover{display:none}", class.clone(), 1),
        // Of two the heavier, of equal ones the later; `style` before both, an attribute after.
        ("path.st0{display:inline} .st0{display:none}", class.clone(), 1),
        (".st0{display:none} .b{display:inline}", class.clone(), 1),
        (".st0{display:none}", line("class=\"st0\" style=\"display:inline\""), 1),
        (".st0{display:none !important}", line("class=\"st0\" style=\"display:inline\""), 0),
        (".st0{display:inline}", line("class=\"st0\" display=\"none\""), 1),
        // A child of what is hidden may show, of what is not displayed never.
        ("g{visibility:hidden} .st0{visibility:visible}", format!("<g>{class}{}</g>", line("")), 1),
        ("g{display:none} .st0{display:inline}", format!("<g>{class}</g>"), 0),
        (".st0{display:none", class.clone(), 0),
        ("}{;;", class.clone(), 1),
    ] {
        assert_eq!(shown(sheet, &inside), count, "{sheet} {inside}");
    }
}

#[test]
fn lines_are_found_by_their_ids() {
    let drawing = draw(
        "<g id=\"axes\"><path id=\"a\" d=\"M0 0 H9\"/><path id=\"b\" d=\"M0 9 H9 M0 20 H9\"/></g><path d=\"M1 1 H9\"/>",
    );
    let count = |id| drawing.called(id).map(|l| l.len());
    assert_eq!((count(None), count(Some("a")), count(Some("b"))), (Ok(4), Ok(1), Ok(2)));
    assert_eq!(count(Some("axes")), Ok(3));
    assert!(drawing.one(Some("a")).is_ok());
    let several = drawing.one(None).unwrap_err().to_string();
    assert!(several.contains("4 lines") && several.contains("'a', 'b'"), "{several}");
    let unknown = count(Some("c")).unwrap_err().to_string();
    assert!(unknown.contains("'c'") && unknown.contains("'a', 'b'"), "{unknown}");
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("drawing.SVG");
    std::fs::write(&file, "<svg viewBox=\"0 0 4 2\"><path id=\"x\" d=\"M0 1H4\"/></svg>").unwrap();
    let stroke = StrokeFile::read(&file, Some("x")).unwrap();
    assert_eq!((stroke.stroke.points.len(), stroke.aspect, stroke.camera), (2, Some(2.0), None));
    assert!(StrokeFile::read(&file, Some("y")).is_err());
}

#[test]
fn bad_drawings_are_told_what_is_wrong() {
    let whole = |text: &str| Drawing::from_svg(text).unwrap_err().to_string();
    assert!(whole("points = 3").contains("no XML"));
    assert!(whole("<svg viewBox=\"0 0 1 1\"><path").contains("no XML"));
    assert!(whole("<html/>").contains("<html>"));
    assert!(fault("").contains("no line"));
    assert!(fault("<text>M0 0</text>").contains("no line"));
    let bad = fault("\n<path d=\"M0 0 L10 ten\"/>");
    assert!(bad.contains("line 3") && bad.contains("<path>") && bad.contains("d=\"M0 0 L10 ten\""), "{bad}");
    assert!(fault("<g transform=\"twist(3)\"><path d=\"M0 0H1\"/></g>").contains("twist"));
    assert!(fault("<circle r=\"big\"/>").contains("big"));
    assert!(fault("<polyline points=\"0,0 1,x\"/>").contains("'x'"));
    assert!(fault("<polyline points=\"0,0 1\"/>").contains("pairs"));
    assert!(fault("<use href=\"#a\"/>").contains("unlink"));
    assert!(fault("<svg><path d=\"M0 0H1\"/></svg>").contains("ungroup"));
    assert!(fault("<path d=\"M0 0 L1e300 0\"/>").contains("fractions"));
    assert!(
        fault("<path d=\"M0 0 L1e999 0\"/>").contains("line 2")
            || fault("<path d=\"M0 0 L1e999 0\"/>").contains("fractions")
    );
    let many = format!("<path d=\"M0 0{}\"/>", "h1v1".repeat(MAX_STROKE_POINTS));
    assert!(fault(&many).contains("points"));
    // Nested deeper than a stack.
    let deep = format!("{}<path d=\"M0 0H1\"/>{}", "<g>".repeat(20_000), "</g>".repeat(20_000));
    let _ = read(&deep);
    // Entities that unfold without end.
    let bomb = "<!DOCTYPE svg [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;&a;&a;\"><!ENTITY c \
        \"&b;&b;&b;&b;&b;&b;&b;&b;\"><!ENTITY d \"&c;&c;&c;&c;&c;&c;&c;&c;\"><!ENTITY e \"&d;&d;&d;&d;&d;&d;&d;&d;\">\
        <!ENTITY f \"&e;&e;&e;&e;&e;&e;&e;&e;\"><!ENTITY g \"&f;&f;&f;&f;&f;&f;&f;&f;\">]><svg viewBox=\"0 0 1 1\">\
        <text>&g;&g;&g;&g;</text></svg>";
    assert!(Drawing::from_svg(bomb).is_err());
}

#[test]
fn mutilated_drawings_never_panic() {
    let good = "<svg viewBox=\"0 0 9 9\"><g transform=\"rotate(30 1,2)\"><path d=\"M1 1c1 2 3 4 5 6a1 2 3 0 1 5 6z\"/>\
        <polygon points=\"1,2 3,4\"/><ellipse rx=\"1\" ry=\"2\"/><image width=\"1\" height=\"2\"/></g></svg>";
    let bytes: Vec<char> = good.chars().collect();
    for i in 0..bytes.len() {
        let cut: String = bytes[..i].iter().collect();
        let _ = Drawing::from_svg(&cut);
        for odd in ['0', '-', '9', 'e', '"', 'Z', '.'] {
            let mut other = bytes.clone();
            other[i] = odd;
            let _ = Drawing::from_svg(&other.iter().collect::<String>());
        }
    }
}
