//! How a stage is run: threads, progress and cancelling. Nothing here ever changes a result.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The caller asked for the work to stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// A sticky flag shared by all its copies: once cancelled, it stays so.
#[derive(Debug, Clone, Default)]
pub struct CancelToken(Arc<AtomicBool>);

impl CancelToken {
    /// Asks every holder of a copy to stop.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether some holder asked for a stop.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Hears how far a stage has come. Calls come from any thread.
pub trait Progress: Send + Sync {
    /// A stage begins; `total` steps are expected (0: not known).
    fn begin(&self, stage: &str, total: u64);
    /// `done` of the stage's steps are done.
    fn at(&self, done: u64);
    /// The stage has ended.
    fn end(&self);
}

struct Silent;

impl Progress for Silent {
    fn begin(&self, _: &str, _: u64) {}
    fn at(&self, _: u64) {}
    fn end(&self) {}
}

/// How to run a stage. `Exec::default()` uses all cores, tells nobody and cannot be cancelled.
#[derive(Clone)]
pub struct Exec {
    pool: Option<Arc<rayon::ThreadPool>>,
    progress: Arc<dyn Progress>,
    cancel: CancelToken,
}

impl Default for Exec {
    fn default() -> Self {
        Self { pool: None, progress: Arc::new(Silent), cancel: CancelToken::default() }
    }
}

impl Exec {
    /// As the default, on `threads` threads (0: all cores).
    ///
    /// # Errors
    /// The system refused to start the threads.
    pub fn with_threads(threads: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        Ok(Self { pool: Some(Arc::new(pool)), ..Self::default() })
    }

    /// The same, reporting to `progress`.
    #[must_use]
    pub fn reporting(mut self, progress: Arc<dyn Progress>) -> Self {
        self.progress = progress;
        self
    }

    /// The same, stopping when `cancel` is cancelled.
    #[must_use]
    pub fn cancelled_by(mut self, cancel: CancelToken) -> Self {
        self.cancel = cancel;
        self
    }

    /// The token that stops this run.
    #[must_use]
    pub fn cancel_token(&self) -> &CancelToken {
        &self.cancel
    }

    /// An error if the run was asked to stop. Long loops call this often.
    ///
    /// # Errors
    /// [`Cancelled`] once the token has been cancelled.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.cancel.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }

    /// Announces a stage of `total` steps (0: not known); it ends when the value is dropped.
    #[must_use]
    pub fn stage(&self, name: &str, total: u64) -> Stage<'_> {
        self.progress.begin(name, total);
        Stage { progress: &*self.progress }
    }

    /// Runs `work` on this run's threads.
    pub fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match &self.pool {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }
}

/// A stage under way.
pub struct Stage<'a> {
    progress: &'a dyn Progress,
}

impl Stage<'_> {
    /// `done` steps are done.
    pub fn at(&self, done: u64) {
        self.progress.at(done);
    }
}

impl Drop for Stage<'_> {
    fn drop(&mut self) {
        self.progress.end();
    }
}
