//! The inputs of examples as points: distances to them and to their mirror images, and how dense they lie.
//!
//! Points are centred and in even and odd coordinates of the mirror ([`Parity`]), so that the distance to an image is
//! that to the point with its odd part negated: mirroring a new input exchanges both distances, to the bit.
//!
//! *Novelty* of an input is its distance to the nearest example or image over the spacing of the examples: the 99th
//! percentile of the distances from each example to its nearest neighbour. Neighbours of the same event (an example's own
//! image; with moments, frames close in time and their images) do not count, and neither do repetitions (closer than 10⁻⁷ of the
//! largest distance from the centre): a clip at 30 Hz would otherwise have the length of a frame's step for a spacing, and a
//! pair given twice a spacing of zero. Examples without a neighbour that counts are left out. If none has one, the
//! spacing is half of the distance across all examples, and if all are at one place a tenth of the input's length (the same
//! length that a kernel gets there).

use nalgebra::DMatrix;

use crate::blocked::{multiply, transposed, view};
use crate::dense::distance_squared;
use crate::error::InputError;
use crate::examples::Examples;
use crate::parity::Parity;

/// Inputs predicted at once. Always as many, filled up with zeros: an answer does not depend on what else is asked.
pub(crate) const CHUNK: usize = 64;
/// Closer than this, relative to the largest distance from the centre, is a repetition.
const REPEATED: f64 = 1e-7;
/// Part of the distances to nearest neighbours that the spacing is not below.
const PERCENTILE: f64 = 0.99;
/// Squared distances up to this, relative to the squared distance from zero, are rounding.
const ROUNDING: f64 = 1e-24;
/// Distances that the median is taken of, about.
const SAMPLE: usize = 1 << 18;
/// Length of inputs all at one place, relative to their distance from zero.
const AT_ONE_PLACE: f64 = 0.1;

/// Points, one a row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cloud {
    parity: Parity,
    mirrored: bool,
    centre: Vec<f64>,
    /// N × D, row-major; even coordinates first.
    points: Vec<f64>,
    /// Squared lengths.
    squares: Vec<f64>,
    n: usize,
}

/// Squared distances of some inputs, each N × inputs, row-major.
#[derive(Clone, Debug, Default)]
pub(crate) struct Squared {
    /// To the points.
    pub own: Vec<f64>,
    /// To their images; empty without a mirror.
    pub image: Vec<f64>,
}

impl Squared {
    /// Zero between all points of a cloud.
    pub fn none(cloud: &Cloud) -> Self {
        let all = cloud.len() * cloud.len();
        Squared { own: vec![0.0; all], image: vec![0.0; if cloud.mirrored() { all } else { 0 }] }
    }
}

impl Cloud {
    /// Of the inputs of examples.
    pub fn of(examples: &Examples) -> Self {
        let inputs = examples.inputs();
        let (n, d) = inputs.shape();
        let parity = Parity::of(examples.mirror().map(|m| m.input.as_slice()), d);
        let mut points = vec![0.0; n * d];
        for (i, row) in points.chunks_exact_mut(d).enumerate() {
            parity.enter(|k| inputs[(i, k)], row);
        }
        // The centre of examples and images has no odd part.
        let mut centre = vec![0.0; d];
        for row in points.chunks_exact(d) {
            centre[..parity.even].iter_mut().zip(row).for_each(|(c, v)| *c += v / n as f64);
        }
        for row in points.chunks_exact_mut(d) {
            row.iter_mut().zip(&centre).for_each(|(v, c)| *v -= c);
        }
        Cloud::new(parity, examples.mirror().is_some(), centre, points)
    }

    fn new(parity: Parity, mirrored: bool, centre: Vec<f64>, points: Vec<f64>) -> Self {
        let d = centre.len();
        let squares = points.chunks_exact(d).map(|p| crate::dense::dot(p, p)).collect();
        Cloud { n: points.len() / d, parity, mirrored, centre, points, squares }
    }

    /// The points with these numbers.
    pub fn subset(&self, keep: &[usize]) -> Self {
        let points: Vec<f64> = keep.iter().flat_map(|&i| self.point(i).to_vec()).collect();
        Cloud::new(self.parity.clone(), self.mirrored, self.centre.clone(), points)
    }

    /// The same points in another metric: every entered coordinate times its scale.
    pub fn scaled(&self, scales: &[f64]) -> Self {
        let mut points = self.points.clone();
        points.chunks_exact_mut(self.dim().max(1)).for_each(|p| scale(p, scales));
        let mut centre = self.centre.clone();
        scale(&mut centre, scales);
        Cloud::new(self.parity.clone(), self.mirrored, centre, points)
    }

    /// The points in some of their entered coordinates only, at least one.
    pub fn within(&self, keep: &[bool]) -> Self {
        let some =
            |p: &[f64]| -> Vec<f64> { p.iter().zip(keep).filter(|(_, k)| **k).map(|(v, _)| *v).collect() };
        let points = self.points.chunks_exact(self.dim()).flat_map(some).collect();
        Cloud::new(self.parity.subset(keep), self.mirrored, some(&self.centre), points)
    }

    /// Of every entered coordinate, what is known of coordinates of inputs.
    pub fn carry<T>(&self, of: impl Fn(usize) -> T) -> Vec<T> {
        self.parity.carry(of)
    }

    /// With the inputs of more examples, about the same centre.
    pub fn and(&self, more: &Examples) -> Self {
        let (inputs, d) = (more.inputs(), self.dim());
        let mut points = self.points.clone();
        let mut row = vec![0.0; d];
        for i in 0..inputs.nrows() {
            self.parity.enter(|k| inputs[(i, k)], &mut row);
            points.extend(row.iter().zip(&self.centre).map(|(v, c)| v - c));
        }
        Cloud::new(self.parity.clone(), self.mirrored, self.centre.clone(), points)
    }

    /// Number of points N.
    pub fn len(&self) -> usize {
        self.n
    }

    /// Coordinates D.
    pub fn dim(&self) -> usize {
        self.centre.len()
    }

    /// Whether points have images.
    pub fn mirrored(&self) -> bool {
        self.mirrored
    }

    /// All of them, row-major.
    pub fn points(&self) -> &[f64] {
        &self.points
    }

    /// Point `i`, centred, even coordinates first.
    pub fn point(&self, i: usize) -> &[f64] {
        &self.points[i * self.dim()..(i + 1) * self.dim()]
    }

    /// Number of even coordinates.
    pub fn even(&self) -> usize {
        self.parity.even
    }

    /// Writes `input` centred and in even and odd coordinates.
    pub fn enter(&self, input: &[f64], out: &mut [f64]) -> Result<(), InputError> {
        if input.len() != self.dim() {
            return Err(InputError::Dimension { found: input.len(), expected: self.dim() });
        }
        if let Some(coordinate) = input.iter().position(|v| !v.is_finite()) {
            return Err(InputError::NotFinite { coordinate, value: input[coordinate] });
        }
        self.parity.enter(|k| input[k], out);
        out.iter_mut().zip(&self.centre).for_each(|(v, c)| *v -= c);
        Ok(())
    }

    /// Writes rows `from..` of `inputs` (F × D), at most [`CHUNK`], into `out` (CHUNK × D); rows beyond are zero. Returns
    /// how many there are.
    pub fn enter_chunk(
        &self,
        inputs: &DMatrix<f64>,
        from: usize,
        row: &mut Vec<f64>,
        out: &mut Vec<f64>,
    ) -> Result<usize, InputError> {
        let d = self.dim();
        let count = (inputs.nrows() - from).min(CHUNK);
        out.clear();
        out.resize(CHUNK * d, 0.0);
        for i in 0..count {
            row.clear();
            row.extend(inputs.row(from + i).iter());
            self.enter(row, &mut out[i * d..(i + 1) * d])?;
        }
        Ok(count)
    }

    /// Squared distances from all points (and images) to the `count` entered inputs `x` (row-major). By products: rounded
    /// in units of the squared lengths, 10⁻¹⁶ of them.
    pub fn squared(&self, x: &[f64], count: usize, out: &mut Squared) {
        let (n, d, e) = (self.n, self.dim(), self.parity.even);
        let squares: Vec<f64> = x.chunks_exact(d).map(|p| crate::dense::dot(p, p)).collect();
        let Squared { own, image } = out;
        own.resize(n * count, 0.0);
        let even = view(&self.points, n, e, d);
        multiply(own, count, -2.0, &even, &transposed(x, count, e, d), 0.0);
        if !self.mirrored {
            for (row, s) in own.chunks_exact_mut(count).zip(&self.squares) {
                row.iter_mut().zip(&squares).for_each(|(v, t)| *v = (*v + (s + t)).max(0.0));
            }
            image.clear();
            return;
        }
        image.resize(n * count, 0.0);
        let odd = d - e;
        if odd == 0 {
            image.fill(0.0);
        } else {
            let points = view(&self.points[e..], n, odd, d);
            multiply(image, count, -2.0, &points, &transposed(&x[e..], count, odd, d), 0.0);
        }
        for ((own, image), s) in
            own.chunks_exact_mut(count).zip(image.chunks_exact_mut(count)).zip(&self.squares)
        {
            for ((a, b), t) in own.iter_mut().zip(image).zip(&squares) {
                let (even, odd) = (*a + (s + t), *b);
                *a = (even + odd).max(0.0);
                *b = (even - odd).max(0.0);
            }
        }
    }

    /// Squared distances from all points (and images) to one entered input, by differences; allocates nothing if the
    /// slices are there. `image` is empty without a mirror.
    pub fn squared_one(&self, x: &[f64], own: &mut [f64], image: &mut [f64]) {
        let (d, e) = (self.dim(), self.parity.even);
        for (i, p) in self.points.chunks_exact(d).enumerate() {
            let even = distance_squared(&p[..e], &x[..e]);
            own[i] = even + distance_squared(&p[e..], &x[e..]);
            if self.mirrored {
                image[i] = even + sum_squared(&p[e..], &x[e..]);
            }
        }
    }

    /// Distance from point `i` or its image to an entered input, by differences.
    fn distance(&self, i: usize, image: bool, x: &[f64]) -> f64 {
        let (p, e) = (self.point(i), self.parity.even);
        let odd = if image { sum_squared(&p[e..], &x[e..]) } else { distance_squared(&p[e..], &x[e..]) };
        (distance_squared(&p[..e], &x[..e]) + odd).sqrt()
    }

    /// Distance from one of the inputs to the nearest of all points and images; `column` of `squared` are its distances, the
    /// number of columns `stride`.
    pub fn nearest(&self, squared: &Squared, column: usize, stride: usize, x: &[f64]) -> f64 {
        let least = |all: &[f64]| {
            let mut best = (0, f64::INFINITY);
            for i in 0..all.len() / stride {
                let v = all[i * stride + column];
                if v < best.1 {
                    best = (i, v);
                }
            }
            best
        };
        let own = least(&squared.own);
        let mut nearest = self.distance(own.0, false, x);
        if self.mirrored {
            let image = least(&squared.image);
            nearest = nearest.min(self.distance(image.0, true, x));
        }
        nearest
    }

    /// How dense the points lie: see the head of this file.
    pub fn extent(&self, examples: &Examples) -> Extent {
        let radius = self.squares.iter().fold(0.0_f64, |a, v| a.max(*v));
        let repeated = REPEATED * REPEATED * radius;
        let mut extent = Extent { nearest: vec![f64::INFINITY; self.n], repeated, ..Extent::default() };
        let mut widest: f64 = 0.0;
        let mut sample = Vec::new();
        let (n, images) = (self.n, if self.mirrored { 2 } else { 1 });
        let step = (images * n * n).div_ceil(SAMPLE);
        self.scan(examples, 0, &mut extent, |i, j, own, image| {
            widest = widest.max(own).max(image.unwrap_or(0.0));
            if i != j && (i + n * j).is_multiple_of(step) {
                sample.push(own);
                sample.extend(image);
            }
        });
        // Points at one place: what is left is the rounding of products.
        let from_zero = radius + crate::dense::dot(&self.centre, &self.centre);
        if widest <= ROUNDING * from_zero {
            let length = AT_ONE_PLACE * from_zero.sqrt();
            extent.spacing = if length > 0.0 { length } else { 1.0 };
            extent.median = extent.spacing;
            return extent;
        }
        extent.diameter = widest.sqrt();
        sample.sort_by(f64::total_cmp);
        let median = sample.get(sample.len() / 2).map_or(0.5 * extent.diameter, |v| v.sqrt());
        extent.median = median.clamp(1e-3 * extent.diameter, extent.diameter);
        extent.space();
        extent
    }

    /// The same when `was` is that of the points before `from`, which are not looked at among themselves again. The median
    /// stays.
    pub fn extent_grown(&self, examples: &Examples, was: &Extent, from: usize) -> Extent {
        if was.diameter == 0.0 {
            return self.extent(examples);
        }
        let mut extent = was.clone();
        extent.nearest.resize(self.n, f64::INFINITY);
        let mut widest = was.diameter.powi(2);
        self.scan(examples, from, &mut extent, |_, _, own, image| {
            widest = widest.max(own).max(image.unwrap_or(0.0));
        });
        extent.diameter = widest.sqrt();
        extent.space();
        extent
    }

    /// Looks at all points against those from `from` on: calls `look` with both numbers and the squared distances to the
    /// point and to its image, and keeps the nearest that counts.
    fn scan(
        &self,
        examples: &Examples,
        from: usize,
        extent: &mut Extent,
        mut look: impl FnMut(usize, usize, f64, Option<f64>),
    ) {
        let (n, d) = (self.n, self.dim());
        let counts = |v: f64| if v > extent.repeated { v } else { f64::INFINITY };
        let nearest = &mut extent.nearest;
        let mut squared = Squared::default();
        for start in (from..n).step_by(CHUNK) {
            let count = (n - start).min(CHUNK);
            self.squared(&self.points[start * d..(start + count) * d], count, &mut squared);
            for (i, row) in squared.own.chunks_exact(count).enumerate() {
                for (k, &own) in row.iter().enumerate() {
                    let j = start + k;
                    let image = squared.image.get(i * count + k).copied();
                    look(i, j, own, image);
                    let least = counts(own).min(image.map_or(f64::INFINITY, counts));
                    let closer = least < nearest[j] || (i < from && least < nearest[i]);
                    if closer && !examples.same_event(i, j) {
                        nearest[j] = nearest[j].min(least);
                        nearest[i] = nearest[i].min(least);
                    }
                }
            }
        }
    }

    /// `count` points, each the farthest from those before (and from their images), the first the farthest from the
    /// centre: their numbers, and the largest distance of any point from the nearest of them.
    pub fn farthest(&self, count: usize) -> (Vec<usize>, f64) {
        let mut chosen = Vec::with_capacity(count);
        let mut left = vec![f64::INFINITY; self.n];
        let (mut own, mut image) = (vec![0.0; self.n], vec![0.0; if self.mirrored { self.n } else { 0 }]);
        let most = |v: &[f64]| (1..v.len()).fold(0, |b, i| if v[i] > v[b] { i } else { b });
        let mut next = most(&self.squares);
        while chosen.len() < count.min(self.n) {
            chosen.push(next);
            self.squared_one(self.point(next), &mut own, &mut image);
            for (i, l) in left.iter_mut().enumerate() {
                *l = l.min(own[i]).min(image.get(i).copied().unwrap_or(f64::INFINITY));
            }
            for &i in &chosen {
                left[i] = -1.0;
            }
            next = most(&left);
        }
        let far = left.iter().fold(0.0_f64, |a, v| a.max(*v)).sqrt();
        (chosen, far)
    }
}

/// Multiplies a point by the scales of its coordinates.
pub(crate) fn scale(point: &mut [f64], scales: &[f64]) {
    point.iter_mut().zip(scales).for_each(|(v, s)| *v *= s);
}

/// |a + b|².
fn sum_squared(a: &[f64], b: &[f64]) -> f64 {
    // Sums in the order of `distance_squared`, so that negating `b` gives the same bits.
    let (ca, cb) = (a.chunks_exact(8), b.chunks_exact(8));
    let tail: f64 = ca.remainder().iter().zip(cb.remainder()).map(|(x, y)| (x + y) * (x + y)).sum();
    let mut s = [0.0; 8];
    for (x, y) in ca.zip(cb) {
        for l in 0..8 {
            s[l] += (x[l] + y[l]) * (x[l] + y[l]);
        }
    }
    ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7])) + tail
}

/// Lengths of a cloud.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Extent {
    /// The largest distance between two points or images; 0 if all are at one place.
    pub diameter: f64,
    /// The 99th percentile of the distances to the nearest neighbour that counts.
    pub spacing: f64,
    /// Median of the distances between points.
    pub median: f64,
    /// Squared distance of each point to the nearest neighbour that counts; infinite if there is none.
    nearest: Vec<f64>,
    /// Squared distance up to which a point is a repetition.
    repeated: f64,
}

impl Extent {
    /// Takes the spacing from the nearest neighbours.
    fn space(&mut self) {
        let mut all: Vec<f64> = self.nearest.iter().copied().filter(|v| v.is_finite()).collect();
        all.sort_by(f64::total_cmp);
        let rank = ((PERCENTILE * all.len() as f64).ceil() as usize).max(1) - 1;
        self.spacing = all.get(rank).map_or(0.5 * self.diameter, |v| v.sqrt());
    }
}
