//! How a command fails: one block on standard error.

use std::error::Error;
use std::fmt;
use std::io::Write;
use std::process::ExitCode;

/// A command that did not succeed.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The command line itself is wrong: exit code 2.
    Usage(String),
    /// Something else is: exit code 1.
    Run {
        /// What could not be done.
        what: Option<String>,
        /// Why.
        why: Box<dyn Error + Send + Sync>,
    },
    /// The user asked it to stop: exit code 130. Says what became of the work, where that is not just lost.
    Stopped(Option<String>),
}

impl Failure {
    /// An argument that cannot be.
    pub(crate) fn usage(message: impl Into<String>) -> Self {
        Self::Usage(message.into())
    }

    /// `what` could not be done because of an error.
    pub(crate) fn because<E: Error + Send + Sync + 'static>(
        what: impl Into<String>,
    ) -> impl FnOnce(E) -> Self {
        let what = what.into();
        move |why| Self::Run { what: Some(what), why: Box::new(why) }
    }

    /// Prints it and gives the exit code.
    pub(crate) fn print(&self) -> ExitCode {
        // Nothing can be done about a standard error that is closed.
        let _ = writeln!(std::io::stderr(), "lapis: {self}");
        ExitCode::from(match self {
            Self::Usage(_) => 2,
            Self::Run { .. } => 1,
            Self::Stopped(_) => 130,
        })
    }
}

impl<E: Error + Send + Sync + 'static> From<E> for Failure {
    fn from(why: E) -> Self {
        Self::Run { what: None, why: Box::new(why) }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(message) => write!(f, "{message}"),
            Self::Stopped(what) => f.write_str(what.as_deref().unwrap_or("stopped")),
            Self::Run { what, why } => {
                let mut last = match what {
                    Some(what) => what.clone(),
                    None => why.to_string(),
                };
                f.write_str(&last)?;
                let mut cause: Option<&dyn Error> =
                    if what.is_some() { Some(why.as_ref()) } else { why.source() };
                while let Some(error) = cause {
                    let text = error.to_string();
                    // Some errors repeat their cause in their own words.
                    if !last.contains(text.trim_end()) {
                        write!(f, "\n  because: {}", text.trim_end().replace('\n', "\n  "))?;
                        last = text;
                    }
                    cause = error.source();
                }
                Ok(())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error)]
    #[error("the file is bad")]
    struct Bad(#[source] std::io::Error);

    #[test]
    fn causes_follow_once() {
        let bad = Bad(std::io::Error::other("the disk is full"));
        let failure = Failure::because("cannot fill")(bad);
        assert_eq!(
            failure.to_string(),
            "cannot fill\n  because: the file is bad\n  because: the disk is full"
        );
        let repeated = Failure::because("cannot fill: the file is bad")(Bad(std::io::Error::other("x")));
        assert_eq!(repeated.to_string(), "cannot fill: the file is bad\n  because: x");
    }
}
