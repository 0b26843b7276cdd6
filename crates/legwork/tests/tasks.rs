//! The tasks and limits of the program as data, for every built-in model.

use std::collections::HashSet;

use legwork::library;
use legwork::qp::Layout;
use legwork::scenario::{QpForm, Scenario};
use legwork_rbd::Model;

fn models() -> impl Iterator<Item = Model> {
    library::model_names().map(|name| library::load_model(name, None).expect("a built-in model"))
}

#[test]
fn every_limit_has_words_and_a_column_of_its_own() {
    let tracking = Scenario::default().controller.tracking;
    for model in models().filter(Model::is_planar) {
        for form in [QpForm::Direct, QpForm::Slack] {
            let layout = Layout::new(form, &tracking, &model);
            let limits = layout.limits();
            assert_eq!(limits.len(), 2 * layout.actuated.len() + layout.rho.len() + layout.friction_rows.len());
            let different = |texts: Vec<String>| texts.iter().collect::<HashSet<_>>().len();
            assert_eq!(different(limits.iter().map(|limit| limit.in_words(&model)).collect()), limits.len());
            assert_eq!(different(limits.iter().map(|limit| limit.column(&model)).collect()), limits.len());
            assert_eq!(limits.iter().map(|limit| limit.kind).collect::<HashSet<_>>().len(), limits.len());
        }
    }
}
