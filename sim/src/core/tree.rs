//! Tree: which degrees of freedom carry which, and where a sparse factor of the tree keeps its rows.
//!
//! In: a [`Model`]. Out: a packed layout of lower triangular matrices whose row k has entries only at the degrees of freedom
//! inboard of k (Featherstone 2008, §6.5). Row k holds them root first and its own last, so that the row of any inboard degree
//! of freedom has the same columns as the beginning of row k: sparse updates run over contiguous memory. Rows are as long as a multiple of
//! [`FOUR`], so that updates take whole fours: what lies past a diagonal means nothing.
//!
//! Symbols: `chain(k)` the degrees of freedom inboard of k, root first, then k; a *position* is an index into a chain; a *block* is
//! the degrees of freedom of one joint; a *run* is a part of a chain whose degrees of freedom are consecutive.

use dynamics::Model;

/// Entries of a row that are taken at once.
pub(super) const FOUR: usize = 4;

/// The degrees of freedom of one joint.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    /// First degree of freedom.
    pub first: usize,
    /// How many.
    pub width: usize,
    /// How many lie inboard.
    pub depth: usize,
    /// Its runs: start and end in [`Tree::runs`].
    runs: (usize, usize),
}

/// Consecutive degrees of freedom at consecutive positions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    /// First degree of freedom.
    pub dof: usize,
    /// Its position.
    pub position: usize,
    /// How many.
    pub len: usize,
}

/// The layout. See the module header.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    /// One per joint with degrees of freedom, inboard ones first.
    pub blocks: Vec<Block>,
    runs: Vec<Run>,
    /// Start of each row, a multiple of [`FOUR`].
    pub at: Vec<usize>,
    entries: usize,
    /// Degrees of freedom inboard of each body's joint.
    pub depth: Vec<usize>,
    /// The chains, and where each begins.
    chain: Vec<usize>,
    starts: Vec<usize>,
    /// Last degree of freedom that moves each body; `None` for one that nothing moves.
    last: Vec<Option<usize>>,
}

impl Tree {
    pub fn new(model: &Model) -> Self {
        let mut tree = Self {
            blocks: Vec::new(),
            runs: Vec::new(),
            at: Vec::new(),
            entries: 0,
            depth: Vec::new(),
            chain: Vec::new(),
            starts: Vec::new(),
            last: Vec::new(),
        };
        for b in &model.bodies {
            let inboard = b.parent.and_then(|p| tree.last[p]);
            let width = b.joint.nv();
            tree.depth.push(inboard.map_or(0, |k| tree.chain(k).len()));
            if width == 0 {
                tree.last.push(inboard);
                continue;
            }
            let outer: Vec<usize> = inboard.map_or(Vec::new(), |k| tree.chain(k).to_vec());
            let start = tree.runs.len();
            for (position, &dof) in outer.iter().enumerate() {
                match tree.runs[start..].last_mut() {
                    Some(run) if run.dof + run.len == dof => run.len += 1,
                    _ => tree.runs.push(Run { dof, position, len: 1 }),
                }
            }
            let runs = (start, tree.runs.len());
            tree.blocks.push(Block { first: b.v_at, width, depth: outer.len(), runs });
            for k in 0..width {
                tree.at.push(tree.entries);
                tree.entries += (outer.len() + k + 1).next_multiple_of(FOUR);
                tree.starts.push(tree.chain.len());
                tree.chain.extend_from_slice(&outer);
                tree.chain.extend(b.v_at..=b.v_at + k);
            }
            tree.last.push(Some(b.v_at + width - 1));
        }
        tree
    }

    /// Entries of a factor, those past diagonals included.
    pub fn entries(&self) -> usize {
        self.entries
    }

    /// Start of row k.
    pub fn at(&self, k: usize) -> usize {
        self.at[k]
    }

    /// Degrees of freedom inboard of k, root first, then k.
    pub fn chain(&self, k: usize) -> &[usize] {
        let end = self.starts.get(k + 1).copied().unwrap_or(self.chain.len());
        &self.chain[self.starts[k]..end]
    }

    /// Degrees of freedom that move a body, root first.
    pub fn moving(&self, body: usize) -> &[usize] {
        self.last[body].map_or(&[], |k| self.chain(k))
    }

    /// Runs of what lies inboard of a block.
    pub fn runs(&self, block: &Block) -> &[Run] {
        &self.runs[block.runs.0..block.runs.1]
    }
}
