use longstep::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let d = domain::shipped(&a[1]).unwrap().unwrap();
    let text = std::fs::read_to_string(&a[2]).unwrap();
    let env = world::Environment::from_json(&text).unwrap();
    let w = world::read(&d, &env, &a[2], &text, &json::Path::default()).unwrap_or_else(|e| panic!("{e}"));
    let mut g = prompt::GoalDialogue::new(&d, &w, &a[3], prompt::ConstraintKind::Grammar);
    let r = g.request();
    println!("{}", r.messages[0].text);
    println!("{}", r.messages.last().unwrap().text);
    println!("{:?}", r.constraint);
    if let Some(t) = a.get(4) {
        let t = g.supply(&prompt::Reply {
            text: t.clone(),
            finish: prompt::Finish::Stop,
            usage: prompt::Usage::default(),
        });
        println!("{t:?}\n{:?}", g.request().constraint);
    }
}
