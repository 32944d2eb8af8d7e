//! An account: from a file or the environment, never from what was typed, and never told to anyone but the source.

use std::path::Path;

use anyhow::anyhow;

use super::arguments::SpaceTrackArguments;
use crate::notices::Notices;

/// User name and password. It has no way of being printed.
pub struct Credentials {
    pub identity: String,
    pub password: String,
}

impl Credentials {
    pub fn of(typed: &SpaceTrackArguments, notices: &Notices) -> anyhow::Result<Self> {
        if let Some(path) = &typed.credentials {
            return of_file(path, notices);
        }
        let variable = |name: &Option<String>, flag: &str| {
            let name =
                name.as_deref().ok_or_else(|| anyhow!("no credentials; say --credentials FILE, or {flag} NAME"))?;
            std::env::var(name)
                .ok()
                .filter(|value| !value.is_empty())
                .ok_or_else(|| anyhow!("the environment variable {name} is not set; {flag} names it"))
        };
        Ok(Self {
            identity: variable(&typed.identity_env, "--identity-env")?,
            password: variable(&typed.password_env, "--password-env")?,
        })
    }
}

fn of_file(path: &Path, notices: &Notices) -> anyhow::Result<Credentials> {
    let shown = path.display();
    let text = std::fs::read_to_string(path).map_err(|error| anyhow!("credentials {shown}: {error}"))?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode =
            std::fs::metadata(path).map_err(|error| anyhow!("credentials {shown}: {error}"))?.permissions().mode();
        if mode & 0o077 != 0 {
            notices.warn(&[format!("credentials {shown} can be read by others (chmod 600 {shown})")]);
        }
    }
    #[cfg(not(unix))]
    let _ = notices;
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    match (lines.next(), lines.next(), lines.next()) {
        (Some(identity), Some(password), None) => {
            Ok(Credentials { identity: identity.to_owned(), password: password.to_owned() })
        }
        _ => Err(anyhow!("credentials {shown}: allowed are two lines, user name and password")),
    }
}
