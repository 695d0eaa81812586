//! Places for words through which no line runs.
//!
//! In: rectangles and polylines on the page, px. Out: whether they touch, and the first of some places that nothing crosses.

use crate::figure::{Anchor, Figure, Mark, Px};
use crate::style::{Color, SMALL};

/// A rectangle `[left, top, right, bottom]`, px.
pub(crate) type Rect = [f64; 4];

/// Whether a line through points touches a rectangle.
pub(crate) fn crossed(rect: &Rect, points: &[Px]) -> bool {
    points.windows(2).any(|pair| segment_touches(rect, pair[0], pair[1]))
}

/// Liang and Barsky: the part of the segment inside each of the four half planes, in turn.
fn segment_touches(rect: &Rect, a: Px, b: Px) -> bool {
    let [mut from, mut to] = [0.0, 1.0];
    for axis in 0..2 {
        let (start, way) = (a[axis], b[axis] - a[axis]);
        let (low, high) = (rect[axis], rect[axis + 2]);
        if way == 0.0 {
            if start < low || start > high {
                return false;
            }
            continue;
        }
        let (s, t) = ((low - start) / way, (high - start) / way);
        from = f64::max(from, s.min(t));
        to = f64::min(to, s.max(t));
    }
    from <= to
}

/// Whether two rectangles overlap.
fn overlap(a: &Rect, b: &Rect) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// Where a word may stand around a point, the best first: to the upper right, below, to the left, above, far above.
const PLACES: [([f64; 2], Anchor); 8] = [
    ([7.0, -6.0], Anchor::Start),
    ([7.0, 14.0], Anchor::Start),
    ([-7.0, -6.0], Anchor::End),
    ([-7.0, 14.0], Anchor::End),
    ([0.0, -9.0], Anchor::Middle),
    ([0.0, 19.0], Anchor::Middle),
    ([12.0, 4.0], Anchor::Start),
    ([-12.0, 4.0], Anchor::End),
];

/// Writes a word beside a point where it meets no line, no other word and not the edge of the frame; where all places are taken,
/// at the one that meets least. What it covers is added to `taken`.
pub(crate) fn word_beside(
    figure: &mut Figure,
    (at, text, color): (Px, &str, Color),
    frame: &Rect,
    lines: &[Vec<Px>],
    taken: &mut Vec<Rect>,
) {
    let place = |([x, y], anchor): &([f64; 2], Anchor)| {
        let (text, at) = (text.to_owned(), [at[0] + x, at[1] + y]);
        let mark = Mark::Text { text, at, size: SMALL, color, anchor: *anchor, upward: false };
        let [l, t, r, b] = Figure::bounds(&mark);
        let rect = [l - 1.5, t - 1.5, r + 1.5, b + 1.5];
        let out = rect[0] < frame[0] || rect[1] < frame[1] || rect[2] > frame[2] || rect[3] > frame[3];
        let met = lines.iter().filter(|line| crossed(&rect, line)).count()
            + taken.iter().filter(|other| overlap(&rect, other)).count();
        (met + usize::from(out), rect, mark)
    };
    let mut best: Option<(usize, Rect, Mark)> = None;
    for candidate in PLACES.iter().map(place) {
        if best.as_ref().is_none_or(|b| candidate.0 < b.0) {
            best = Some(candidate);
        }
    }
    if let Some((_, rect, mark)) = best {
        taken.push(rect);
        figure.marks.push(mark);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_and_rectangles() {
        let rect = [10.0, 20.0, 30.0, 40.0];
        for (a, b, touches) in [
            ([0.0, 0.0], [50.0, 50.0], true),
            ([0.0, 30.0], [50.0, 30.0], true),
            ([15.0, 25.0], [16.0, 26.0], true),
            ([0.0, 0.0], [5.0, 50.0], false),
            ([0.0, 45.0], [50.0, 45.0], false),
            ([0.0, 38.0], [8.0, 60.0], false),
            ([20.0, 0.0], [20.0, 19.0], false),
            ([20.0, 0.0], [20.0, 21.0], true),
        ] {
            assert_eq!(segment_touches(&rect, a, b), touches, "{a:?} {b:?}");
            assert_eq!(segment_touches(&rect, b, a), touches, "{b:?} {a:?}");
        }
        assert!(!crossed(&rect, &[[20.0, 30.0]]));
    }

    /// A line to the upper right sends the word elsewhere; a second word at the same point goes to a third place.
    #[test]
    fn a_word_stands_clear_of_lines_and_words() {
        let mut figure = Figure::new(200.0, 200.0);
        let (frame, line) = ([0.0, 0.0, 200.0, 200.0], vec![[100.0, 100.0], [200.0, 0.0]]);
        let mut taken = Vec::new();
        for _ in 0..3 {
            let word = ([100.0, 100.0], "0.5", crate::style::SOFT);
            word_beside(&mut figure, word, &frame, std::slice::from_ref(&line), &mut taken);
        }
        assert!(taken.iter().all(|rect| !crossed(rect, &line)), "{taken:?}");
        assert!(!overlap(&taken[0], &taken[1]) && !overlap(&taken[1], &taken[2]), "{taken:?}");
        // in a corner it stays inside
        word_beside(&mut figure, ([199.0, 1.0], "0.5", crate::style::SOFT), &frame, &[], &mut taken);
        assert!(taken[3][2] <= 200.0 && taken[3][1] >= 0.0, "{taken:?}");
    }
}
