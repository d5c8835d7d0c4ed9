//! Regular expressions over bounces as automata (K. Thompson, Regular Expression Search Algorithm,
//! CACM 11(6), 1968): they have as many steps as the expression has parts.

use std::collections::HashSet;

use super::Pattern;
use crate::transport::Bounce;

/// A part of an expression.
#[derive(Clone, Debug)]
pub(super) enum Node {
    /// A bounce that fits one of these, or none of them.
    One {
        patterns: Vec<Pattern>,
        is_none: bool,
    },
    /// One after the other.
    Row(Vec<Self>),
    /// One or the other.
    Either(Vec<Self>),
    /// As often as from the first number to the second.
    Repeat(Box<Self>, u32, Option<u32>),
}

/// A step of an automaton.
#[derive(Clone, Debug)]
pub(super) enum Step {
    /// Takes a bounce.
    Take {
        patterns: Vec<Pattern>,
        is_none: bool,
    },
    /// Goes on at either place.
    Fork(usize, usize),
    /// The row is taken; the first step is such a one.
    Accept,
}

/// Takes rows of bounces.
#[derive(Clone, Debug)]
pub(super) struct Automaton {
    pub(super) steps: Vec<Step>,
    pub(super) start: u32,
}

impl Node {
    /// The same for rows that are read from their other end.
    pub(super) fn reversed(self) -> Self {
        let all = |nodes: Vec<Self>| nodes.into_iter().map(Self::reversed);
        match self {
            Self::One { .. } => self,
            Self::Row(nodes) => Self::Row(all(nodes).rev().collect()),
            Self::Either(nodes) => Self::Either(all(nodes).collect()),
            Self::Repeat(node, least, most) => Self::Repeat(node.reversed().into(), least, most),
        }
    }
}

impl Automaton {
    /// Steps, at most.
    const MAX_STEPS: usize = 4096;

    /// Takes what the expression stands for; `None` if it would be too large.
    pub(super) fn new(node: &Node) -> Option<Self> {
        let mut builder = Builder {
            steps: vec![Step::Accept],
            n_parts: 0,
        };
        let start = builder.add(node, 0)?;
        Some(Self {
            steps: builder.steps,
            start: start as u32,
        })
    }

    /// The step after one that takes such a bounce.
    pub(super) fn after(&self, step: u32, bounce: &Bounce) -> Option<u32> {
        let Step::Take { patterns, is_none } = &self.steps[step as usize] else {
            return None;
        };
        let fits = patterns.iter().any(|pattern| pattern.fits(bounce)) != *is_none;
        // What is behind a step was added before it.
        fits.then(|| step - 1)
    }

    /// Steps that take something, or accept, which these lead to, in order.
    pub(super) fn entered(&self, steps: impl IntoIterator<Item = u32>) -> Vec<u32> {
        let mut waiting: Vec<u32> = steps.into_iter().collect();
        let mut marked = HashSet::new();
        let mut entered = Vec::new();
        while let Some(at) = waiting.pop() {
            if !marked.insert(at) {
                continue;
            }
            match self.steps[at as usize] {
                Step::Fork(a, b) => waiting.extend([a as u32, b as u32]),
                Step::Take { .. } | Step::Accept => entered.push(at),
            }
        }
        entered.sort_unstable();
        entered
    }
}

struct Builder {
    steps: Vec<Step>,
    /// Parts so far, those that need no step among them.
    n_parts: usize,
}

impl Builder {
    /// Adds the steps of a part that goes on at `next`; yields where it begins.
    fn add(&mut self, node: &Node, next: usize) -> Option<usize> {
        self.n_parts += 1;
        if self.n_parts.max(self.steps.len()) > Automaton::MAX_STEPS {
            return None;
        }
        match node {
            Node::One { patterns, is_none } => {
                if next + 1 != self.steps.len() {
                    self.push(Step::Fork(next, next));
                }
                Some(self.push(Step::Take {
                    patterns: patterns.clone(),
                    is_none: *is_none,
                }))
            }
            Node::Row(nodes) => {
                let mut from_last = nodes.iter().rev();
                from_last.try_fold(next, |next, node| self.add(node, next))
            }
            Node::Either(nodes) => {
                let mut nodes = nodes.iter();
                let first = self.add(nodes.next()?, next)?;
                nodes.try_fold(first, |before, node| {
                    let this = self.add(node, next)?;
                    Some(self.push(Step::Fork(before, this)))
                })
            }
            Node::Repeat(node, least, most) => {
                let start = match most {
                    None => {
                        let fork = self.push(Step::Accept);
                        let body = self.add(node, fork)?;
                        self.steps[fork] = Step::Fork(body, next);
                        fork
                    }
                    Some(most) => (*least..*most).try_fold(next, |start, _| {
                        let body = self.add(node, start)?;
                        Some(self.push(Step::Fork(body, next)))
                    })?,
                };
                (0..*least).try_fold(start, |next, _| self.add(node, next))
            }
        }
    }

    fn push(&mut self, step: Step) -> usize {
        self.steps.push(step);
        self.steps.len() - 1
    }
}
