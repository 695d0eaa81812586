//! What a body carries while a pass runs: who holds what in which row.
//!
//! In: the masses of a pass, with their times. Out: the body to simulate in each step, and the rows as a trace
//! records them. A mass moves with its link during every step that begins while it is carried.

use std::sync::Arc;

use bodies::Character;
use dynamics::Carrying;
use dynamics::Handed;

/// What a body carries, over the rows of a run.
pub(crate) struct Load {
    bare: Arc<Character>,
    all: Vec<Carrying>,
    now: Vec<bool>,
    rate_hz: f64,
    rows: usize,
}

impl Load {
    pub(crate) fn new(bare: Arc<Character>, all: Vec<Carrying>, rate_hz: f64, rows: usize) -> Self {
        let now = all.iter().map(|c| c.at(0.0)).collect();
        Self { bare, all, now, rate_hz, rows }
    }

    /// The body with what it carries now.
    pub(crate) fn character(&self) -> Character {
        self.bare.carrying(self.all.iter().zip(&self.now).filter(|(_, now)| **now).map(|(c, _)| &c.what))
    }

    /// Whether anything comes or goes during the run.
    pub(crate) fn changes(&self) -> bool {
        let end = self.rows as f64 / self.rate_hz;
        self.all.iter().any(|c| c.at(0.0) != (c.from_s < end) || c.to_s < end)
    }

    /// Goes to the step that ends at a row; whether anything came or went.
    pub(crate) fn step_to(&mut self, row: usize) -> bool {
        let t = (row - 1) as f64 / self.rate_hz;
        let mut changed = false;
        for (c, now) in self.all.iter().zip(&mut self.now) {
            changed |= c.at(t) != *now;
            *now = c.at(t);
        }
        changed
    }

    /// As a trace records it.
    pub(crate) fn handed(&self) -> Vec<Handed> {
        let carried = |row: usize, c: &Carrying| c.at(row.saturating_sub(1) as f64 / self.rate_hz);
        let of = |c: &Carrying| {
            let mut rows = (0..self.rows).filter(|&row| carried(row, c));
            let from_row = rows.next().unwrap_or(self.rows);
            let to_row = rows.next_back().map_or((from_row + 1).min(self.rows), |last| last + 1);
            Handed { what: c.what.clone(), from_row, to_row }
        };
        self.all.iter().map(of).collect()
    }
}
