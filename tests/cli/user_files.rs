//! Files of the user beside an output: they are neither removed nor waited for, whatever their names are.

use std::fs;
use std::path::Path;
use std::time::Duration;

use crate::common::cli::{FLAG, SKY, done, is_ignored, path, run};
use assert_cmd::Command;
use tempfile::TempDir;

/// Time limit that only stops a blocked run.
const LONG: Duration = Duration::from_secs(600);
/// Names of the form of temporary files.
const TEMPORARY: [&str; 2] =
    [".streakcast-0aAbcdefghijklmnopqrstuvwxyz2345.part", ".streakcast-1aAbcdefghijklmnopqrstuvwxyz2345.part"];

#[test]
fn hidden_files_of_the_user_are_kept() {
    let folder = TempDir::new().unwrap();
    let [policy, token, lock] = [".streakcast-policy.toml", ".streakcast-token", ".streakcast-notes/lock"];
    fs::create_dir(folder.path().join(".streakcast-notes")).unwrap();
    for (name, text) in
        [(policy, "limit_mag = 6.5\n"), (token, "secret"), (lock, ""), (".streakcast-notes/mine", "mine")]
    {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let schedule = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../examples/night.csv");
    let [policy, output] = [policy, "out.csv"].map(|name| path(&folder, name));
    done(&[&["flag", "--schedule", schedule, "--fov", "3.5deg", "--policy", &policy, "-o", &output], SKY]);
    let mut names: Vec<String> =
        fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!(names, [".streakcast-notes", ".streakcast-policy.toml", token, "out.csv"]);
    assert!(folder.path().join(".streakcast-notes/mine").exists() && folder.path().join(lock).exists());
}

/// A missing folder of an output is created when the file is written, by all verbs alike.
#[test]
fn missing_folders_of_outputs_are_created() {
    let folder = TempDir::new().unwrap();
    let schedule = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../examples/night.csv");
    let new = |name: &str| path(&folder, &format!("new/{name}"));
    let [flags, annotated, map, picture] = ["a/flags.csv", "b/night.csv", "c/map.csv", "d/map.png"].map(new);
    done(&[&["flag", "--schedule", schedule, "--fov", "3.5deg", "-o", &flags], SKY]);
    done(&[&["annotate", "--schedule", schedule, "--fov", "3.5deg", "-o", &annotated], SKY]);
    let sun = ["--model", "starlink-v1.5", "--sun-altitude-deg", "-16", "--step-deg", "5"];
    done(&[&["map", "sky", "-o", &map, "--picture", &picture], &sun]);
    for file in [flags, annotated, map, picture] {
        assert!(fs::metadata(&file).unwrap().len() > 0, "{file}");
    }
    // A run that fails creates none.
    let failed = new("e/flags.csv");
    let (code, _, _) = run(&[&["flag", "--schedule", "none.csv", "--fov", "3.5deg", "-o", &failed], SKY]);
    assert!(code == 2 && !folder.path().join("new/e").exists());
}

fn pipe(path: &Path) {
    assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success());
}

#[test]
fn named_pipes_with_the_names_of_temporary_files_are_not_waited_for() {
    let folder = TempDir::new().unwrap();
    for inner in [".streakcast-x", TEMPORARY[0]] {
        fs::create_dir(folder.path().join(inner)).unwrap();
        pipe(&folder.path().join(inner).join("lock"));
    }
    for name in [".streakcast-y", TEMPORARY[1]] {
        pipe(&folder.path().join(name));
    }
    let schedule = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../examples/night.csv");
    let [passes, flags, status] = ["passes.csv", "flags.csv", "status.json"].map(|name| path(&folder, name));
    let field = ["--ra", "217.5", "--dec=-30", "--fov", "8deg", "--exposure", "10s"];
    let cache = folder.path().display().to_string();
    let commands: [&[&[&str]]; 4] = [
        &[&["passes", "--start", "2024-08-14T23:30:00Z", "-o", &passes], &field, SKY],
        &[&["flag", "--schedule", schedule, "-o", &flags], FLAG, SKY],
        &[&["gate", "--now", "2024-08-14T23:30:00Z", "--limit-mag", "7", "--status-file", &status], &field, SKY],
        // No server answers, but the sidecar is written before.
        &[&["fetch", "celestrak", "--group", "starlink", "--cache", &cache, "--base-url", "http://127.0.0.1:9"]],
    ];
    for command in commands {
        let output = Command::new(env!("CARGO_BIN_EXE_streakcast"))
            .env("STREAKCAST_NO_HOME", "1")
            .args(command.concat())
            .timeout(LONG)
            .output()
            .unwrap();
        assert!(output.status.code().is_some(), "{}: stopped after {LONG:?}", command[0][0]);
    }
    for name in ["passes.csv", "flags.csv", "status.json", TEMPORARY[0], TEMPORARY[1], ".streakcast-x/lock"] {
        assert!(folder.path().join(name).symlink_metadata().is_ok(), "{name} is missing");
    }
}

/// A file of tokens or coordinates that is private stays private.
#[test]
fn outputs_keep_the_permissions_of_the_files_they_replace() {
    use std::os::unix::fs::PermissionsExt;
    let folder = TempDir::new().unwrap();
    let output = path(&folder, "sites.csv");
    fs::write(&output, "old").unwrap();
    fs::set_permissions(&output, PermissionsExt::from_mode(0o600)).unwrap();
    done(&[&["sites", "-o", &output]]);
    assert_ne!(fs::read_to_string(&output).unwrap(), "old");
    assert_eq!(fs::metadata(&output).unwrap().permissions().mode() & 0o777, 0o600);
}

/// Files of another user with the names of temporary files are kept, and a replaced file stays that of its owner.
#[test]
fn files_of_other_users_stay_theirs() {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, chown};
    const OTHER: (u32, u32) = (12_345, 54_321);
    let folder = TempDir::new().unwrap();
    let output = path(&folder, "sites.csv");
    let theirs = folder.path().join(TEMPORARY[0]);
    for file in [Path::new(&output), &theirs] {
        fs::write(file, "old").unwrap();
        fs::set_permissions(file, PermissionsExt::from_mode(0o640)).unwrap();
        if chown(file, Some(OTHER.0), Some(OTHER.1)).is_err() {
            return println!("SKIPPED: only root can create files of another user");
        }
    }
    done(&[&["sites", "-o", &output]]);
    assert_eq!(fs::read_to_string(theirs).unwrap(), "old");
    let status = fs::metadata(&output).unwrap();
    assert!(status.len() > 3);
    assert_eq!((status.uid(), status.gid(), status.mode() & 0o777), (OTHER.0, OTHER.1, 0o640));
}

/// Returns the signal that ended a long run, which was sent two signals.
fn ended_by(shell: &str, signals: [&str; 2]) -> Option<i32> {
    use std::os::unix::process::ExitStatusExt;
    let folder = TempDir::new().unwrap();
    // A server that does not respond: the gate waits for its positions.
    let server = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = server.local_addr().unwrap().to_string();
    let mut child = std::process::Command::new("sh")
        .args([
            "-c",
            &format!("{shell} exec \"$@\""),
            "sh",
            env!("CARGO_BIN_EXE_streakcast"),
            "gate",
            "--indi",
            &address,
        ])
        .args(["--fov", "8deg", "--exposure", "10s", "--timeout", "600s", "--limit-mag", "7"])
        .args(SKY)
        .current_dir(folder.path())
        .spawn()
        .unwrap();
    let connection = server.accept().unwrap();
    for signal in signals {
        let sent = std::process::Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
        assert!(sent.success());
    }
    let status = child.wait().unwrap();
    drop(connection);
    status.signal()
}

#[test]
fn signals_end_the_program_unless_its_parent_ignores_them() {
    for (signal, number) in [("-HUP", 1), ("-QUIT", 3)] {
        assert!(is_ignored(signal, number as u32) || ended_by("", [signal, signal]) == Some(number), "{signal}");
    }
    if cfg!(target_os = "linux") {
        // As by nohup, and by shells for commands in the background.
        assert_eq!(ended_by("trap '' HUP INT QUIT;", ["-HUP", "-TERM"]), Some(15));
        assert_eq!(ended_by("trap '' HUP INT QUIT;", ["-INT", "-TERM"]), Some(15));
    }
}
