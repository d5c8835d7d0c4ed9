//! Regular expressions over bounces, taken in all at once (K. Thompson, Regular Expression Search
//! Algorithm, CACM 11(6), 1968): time is the product of both lengths, whatever the expression.

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

#[derive(Clone, Debug)]
enum Step {
    /// Takes a bounce.
    Take {
        patterns: Vec<Pattern>,
        is_none: bool,
    },
    /// Goes on at either place.
    Fork(usize, usize),
    Accept,
}

/// Takes rows of bounces.
#[derive(Clone, Debug)]
pub(super) struct Automaton {
    steps: Vec<Step>,
    start: usize,
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
            start,
        })
    }

    /// True if it takes the whole row.
    pub(super) fn accepts<'a>(&self, bounces: impl Iterator<Item = &'a Bounce>) -> bool {
        let mut now = vec![false; self.steps.len()];
        self.enter(&mut now, self.start);
        for bounce in bounces {
            let mut next = vec![false; self.steps.len()];
            for (at, step) in self.steps.iter().enumerate() {
                if now[at]
                    && let Step::Take { patterns, is_none } = step
                    && patterns.iter().any(|pattern| pattern.fits(bounce)) != *is_none
                {
                    // What is behind a step was added before it.
                    self.enter(&mut next, at - 1);
                }
            }
            now = next;
        }
        now[0]
    }

    /// Marks a step, and those that it forks into.
    fn enter(&self, marked: &mut [bool], step: usize) {
        let mut waiting = vec![step];
        while let Some(at) = waiting.pop() {
            if !std::mem::replace(&mut marked[at], true)
                && let Step::Fork(a, b) = self.steps[at]
            {
                waiting.extend([a, b]);
            }
        }
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
