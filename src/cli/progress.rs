//! Progress bars on standard error.

use std::sync::Mutex;
use std::time::Duration;

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use lapis::exec::Progress;

/// One bar for each stage under way; a stage inside another one stands below it.
pub(crate) struct Bars {
    all: MultiProgress,
    open: Mutex<Vec<ProgressBar>>,
}

impl Bars {
    /// Bars on standard error, which must be a terminal.
    pub(crate) fn new() -> Self {
        let all = MultiProgress::with_draw_target(ProgressDrawTarget::stderr());
        Self { all, open: Mutex::new(Vec::new()) }
    }

    fn last(&self, act: impl FnOnce(&mut Vec<ProgressBar>)) {
        // A poisoned lock means that a worker panicked: that error is reported elsewhere.
        if let Ok(mut open) = self.open.lock() {
            act(&mut open);
        }
    }
}

impl Progress for Bars {
    fn begin(&self, stage: &str, total: u64) {
        let (bar, template) = if total == 0 {
            (ProgressBar::new_spinner(), "{spinner} {msg:28} {elapsed:>4}")
        } else {
            (ProgressBar::new(total), "{spinner} {msg:28} {elapsed:>4} {wide_bar:.green/dim} {pos}/{len}")
        };
        let bar = self.all.add(bar);
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.set_message(stage.to_owned());
        bar.enable_steady_tick(Duration::from_millis(120));
        self.last(|open| open.push(bar));
    }

    fn at(&self, done: u64) {
        self.last(|open| {
            if let Some(bar) = open.last() {
                bar.set_position(done);
            }
        });
    }

    fn end(&self) {
        self.last(|open| {
            if let Some(bar) = open.pop() {
                bar.finish_and_clear();
                self.all.remove(&bar);
            }
        });
    }
}
