use streakcast::catalogue::*;
fn walk(d: &std::path::Path, o: &mut Vec<std::path::PathBuf>) {
    for e in std::fs::read_dir(d).unwrap() {
        let p = e.unwrap().path();
        if p.is_dir() { walk(&p, o) } else { o.push(p) }
    }
}
#[test]
fn survey() {
    let d = std::path::PathBuf::from(std::env::var("STREAKCAST_DATA").unwrap());
    let mut f = vec![];
    walk(&d.join("tle"), &mut f);
    walk(&d.join("reference/sgp4_vallado"), &mut f);
    walk(&d.join("derived"), &mut f);
    f.sort();
    for p in f {
        let t = std::time::Instant::now();
        let n = p.strip_prefix(&d).unwrap().display().to_string();
        match Catalogue::read(&[&p], &ReadOptions::default()) {
            Ok(c) => {
                let s = &c.sources[0];
                println!(
                    "{n}: {} rec {} rej {} obj {} dup {} sup {} {} .. {} {:.1}ms",
                    s.format,
                    s.records,
                    s.rejected,
                    c.element_sets.len(),
                    c.duplicates,
                    c.superseded,
                    s.first_epoch,
                    s.last_epoch,
                    t.elapsed().as_secs_f64() * 1e3
                );
                for r in c.rejected.iter().take(3) {
                    println!("      {}: {}", r.line, r.reason)
                }
            }
            Err(e) => println!("{n}: ERR {e}"),
        }
    }
}
