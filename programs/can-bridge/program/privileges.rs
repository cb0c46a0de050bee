//! Rights that the program was lent and its user lacks.

use std::io;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use rustix::fs::getxattr_query;
use rustix::io::Errno;

/// Refuses to load code that the user names where the file of the program has capabilities (setcap) or is setuid: whoever may start it would lend them to any code.
pub fn refuse_foreign_code() -> Result<()> {
    let program = Path::new("/proc/self/exe");
    let lent = lends_rights(program).context("cannot tell whether this program has file capabilities")?;
    ensure!(
        !lent,
        "--controller: the file of this program has capabilities (setcap) or is setuid, and then it runs no code but its own. Take them off \
         (`sudo setcap -r`) and give the user rtprio and memlock in /etc/security/limits.d instead"
    );
    Ok(())
}

/// Whether a program that is started from this file has rights that its user lacks.
fn lends_rights(file: &Path) -> io::Result<bool> {
    let has_capabilities = match getxattr_query(file, "security.capability") {
        Ok(size) => size > 0,
        Err(Errno::NODATA | Errno::NOTSUP) => false,
        Err(error) => return Err(error.into()),
    };
    const SETUID_OR_SETGID: u32 = 0o6000;
    let mode = std::fs::metadata(file)?.permissions().mode();
    Ok(has_capabilities || mode & SETUID_OR_SETGID != 0)
}

#[cfg(test)]
mod tests {
    use std::fs::{self, Permissions};

    use super::*;

    #[test]
    fn a_file_that_lends_rights_is_told_from_others() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("program");
        fs::write(&file, "").unwrap();
        assert!(!lends_rights(&file).unwrap());
        fs::set_permissions(&file, Permissions::from_mode(0o4755)).unwrap();
        assert!(lends_rights(&file).unwrap());
        fs::set_permissions(&file, Permissions::from_mode(0o755)).unwrap();
        // cap_sys_nice=ep, as setcap writes it; who may not write it is no root.
        let nice = [1, 0, 0, 2, 0, 0, 128, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
        let flags = rustix::fs::XattrFlags::empty();
        if rustix::fs::setxattr(&file, "security.capability", &nice, flags).is_ok() {
            assert!(lends_rights(&file).unwrap());
        }
        assert!(lends_rights(&folder.path().join("none")).is_err());
    }
}
