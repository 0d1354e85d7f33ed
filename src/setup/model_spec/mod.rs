//! What the model of a robot is made of: effects, known values, bounds, the load, what is known before a fit.

mod declaration;

use crate::chain::crosstalk::Heard;
use crate::chain::effect::{self, Catalogue, Effect, Law};
use crate::chain::model::{Model, ModelSettings, Payload};
use crate::chain::parameter::Role;
use crate::chain::prior::Prior;
use crate::chain::sharing::Sharing;
use crate::fault::Place;
use crate::mechanism::loops::Mechanism;
use crate::robot::description::Dependent;
use crate::setup::declared::FileValue;
use crate::setup::error::{Mismatch, SetupError, at};
use crate::setup::known::Constraints;
use crate::setup::platform::PlatformSpec;
use crate::setup::prior::PriorSpec;
use crate::setup::sharing::Alike;
use crate::setup::{declared, sharing};
use nalgebra::DMatrix;

/// What the model of a robot is made of, without the form of a file: models with further physics are built from it without
/// reading a table again.
#[derive(Debug, Clone)]
pub struct ModelSpec {
    /// Tree, signal, drives, and the effects of every joint.
    settings: ModelSettings,
    payload: Option<DeclaredLoad>,
    /// Joints that follow others.
    dependents: Vec<Dependent>,
    platform: PlatformSpec,
    mechanism: Option<Mechanism>,
    /// Positions are recorded on the joints, not on the motors.
    position_of_joints: bool,
    /// Joints with motors of one type.
    alike: Vec<Alike>,
    /// What the robot file says of the drives.
    file_values: Vec<FileValue>,
    constraints: Constraints,
    prior: PriorSpec,
    /// Where what cannot be built is to be mended.
    place: Place,
}

/// A load that the robot is said to carry.
#[derive(Debug, Clone)]
struct DeclaredLoad {
    /// Where it hangs.
    payload: Payload,
    /// The frame that it is given in, where that is not its link's.
    frame: Option<String>,
}

/// Physics beside what is declared.
#[derive(Debug, Clone, Default)]
pub struct Addition {
    /// (joint, effect): the effect is put behind those of the joint.
    pub effects: Vec<(usize, &'static Effect)>,
    /// Entries (row, column) of V that become free.
    pub coupling: Vec<(usize, usize)>,
    /// Channels that hear others.
    pub crosstalk: Vec<Heard>,
    /// Effects whose parameters joints have in common, beside those that are declared.
    pub shared: Vec<Sharing>,
}

impl Addition {
    /// Adds an effect to a joint, or to an ordered pair of joints.
    pub fn add(&mut self, effect: &'static Effect, joint: usize, other: Option<usize>) {
        match (effect.law, other) {
            (Law::Crosstalk, Some(source)) => self.crosstalk.push(Heard {
                channel: joint,
                source,
            }),
            (_, Some(other)) => self.coupling.push((joint, other)),
            (_, None) => self.effects.push((joint, effect)),
        }
    }
}

/// A model with what is known of its parameters before a fit.
#[derive(Debug, Clone)]
pub struct ModelWithPrior {
    /// The model.
    pub model: Model,
    /// Of its parameters.
    pub prior: Prior,
}

impl ModelSpec {
    /// The same in which every joint has its own parameters.
    pub fn separated(&self) -> Self {
        let mut separated = self.clone();
        separated.settings.shared.clear();
        separated.alike.clear();
        separated
    }

    /// The effects that its joints may have.
    pub fn catalogue(&self) -> &Catalogue {
        &self.settings.catalogue
    }

    /// The effects of every joint, in the order of the tree.
    pub fn effects(&self) -> &[Vec<&'static Effect>] {
        &self.settings.effects
    }

    /// The same with other effects of every joint.
    pub fn with_effects(&self, effects: Vec<Vec<&'static Effect>>) -> Self {
        let mut other = self.clone();
        other.settings.shared = sharing::declared(&self.alike, &effects);
        other.settings.effects = effects;
        other
    }

    /// Puts an effect behind those of a joint that has not got it.
    pub fn add_effect(&mut self, joint: usize, effect: &'static Effect) {
        add(&mut self.settings.effects[joint], effect);
    }

    /// Gives the entry of V its value by which a motor moves a joint.
    ///
    /// # Errors
    /// A joint that is locked; `place` says where it is coupled.
    pub fn couple(
        &mut self,
        entry: [usize; 2],
        value: f64,
        place: &Place,
    ) -> Result<(), SetupError> {
        let n = self.settings.tree.len();
        let [row, column] = entry;
        if self.settings.locked[row] && value != 0.0 {
            let joint = self.settings.tree.joints()[row].name.clone();
            return Err(SetupError::mismatch(
                place,
                Mismatch::LockedCoupled { joint },
            ));
        }
        let matrix = &mut self.settings.coupling;
        matrix.get_or_insert_with(|| DMatrix::identity(n, n))[(row, column)] = value;
        Ok(())
    }

    /// Whether V is given.
    pub fn has_coupling(&self) -> bool {
        self.settings.coupling.is_some()
    }

    /// Whether rotor inertias are given.
    pub fn has_rotor_inertias(&self) -> bool {
        self.settings.rotor_inertia.is_some()
    }

    /// Whether a load is declared.
    pub fn has_load(&self) -> bool {
        self.payload.is_some()
    }

    /// What joints with motors of one type may have in common beside what a model shares.
    pub fn proposed_sharing(&self, model: &Model) -> Vec<Sharing> {
        sharing::proposed(&self.alike, model)
    }

    /// Whether joints are said to have motors of one type.
    pub fn has_motors_of_one_type(&self) -> bool {
        !self.alike.is_empty()
    }

    /// What the robot file says of the drives.
    pub fn file_values(&self) -> &[FileValue] {
        &self.file_values
    }

    /// The frame that a declared load is given in, where it has one of its own.
    pub fn load_frame(&self) -> Option<&str> {
        self.payload.as_ref()?.frame.as_deref()
    }

    /// The model, and what is known of its parameters before a fit.
    ///
    /// # Errors
    /// Effects that do not go together, values outside of their bounds, names that no parameter has.
    pub fn build(&self) -> Result<ModelWithPrior, SetupError> {
        self.build_with(&Addition::default())
    }

    /// The same with further physics.
    ///
    /// # Errors
    /// As [`ModelSpec::build`].
    pub fn build_with(&self, addition: &Addition) -> Result<ModelWithPrior, SetupError> {
        let mut model = self.chain(addition)?;
        if let Some(mechanism) = &self.mechanism {
            self.may_close(&model)?;
            model.close(mechanism.clone());
        }
        self.keep_declared_entries(&mut model, &addition.coupling)?;
        declared::apply(&self.file_values, &mut model);
        self.constraints.apply(&mut model)?;
        let prior = self.prior.build(&mut model)?;
        Ok(ModelWithPrior { model, prior })
    }

    /// The chain from motors to signals, its parameters free.
    fn chain(&self, addition: &Addition) -> Result<Model, SetupError> {
        let mut settings = self.settings.clone();
        // What is added shares nothing unless that is asked for: a hypothesis about one joint has its own parameters.
        settings.shared.extend(addition.shared.iter().cloned());
        settings.crosstalk.extend_from_slice(&addition.crosstalk);
        let freed = addition.coupling.as_slice();
        let of_coupling = freed.iter().map(|&(row, _)| (row, effect::COUPLING));
        for (joint, effect) in addition.effects.iter().copied().chain(of_coupling) {
            add(&mut settings.effects[joint], effect);
        }
        let carries = |list: &Vec<&Effect>| list.iter().any(|e| matches!(e.law, Law::Body));
        let carried = settings.effects.iter().rposition(carries);
        settings.payload = self
            .payload
            .as_ref()
            .map(|load| load.payload)
            .or(carried.map(on));
        let n = settings.tree.len();
        settings.coupling = with_entries(settings.coupling, freed, n);
        let mut model = Model::new(settings).map_err(|e| at(&self.place, e))?;
        model.follow(&self.dependents);
        self.platform.apply(&mut model);
        if self.position_of_joints {
            let declared = self.settings.coupling.clone();
            let reference = declared.unwrap_or_else(|| DMatrix::identity(n, n));
            model.record_joints(model.with_followers(reference));
        }
        Ok(model)
    }

    /// Loops stay closed only where nothing moves their joints beside the motors.
    fn may_close(&self, model: &Model) -> Result<(), SetupError> {
        let mut effects = model.joints().iter().flat_map(|joint| &joint.effects);
        let Some((effect, _)) = effects.find(|(effect, _)| effect.law.moves_joints()) else {
            return Ok(());
        };
        let what = format!(
            "joints that close loops have no `{}`: the loops would move with it",
            effect.id
        );
        Err(SetupError::mismatch(
            &self.place,
            Mismatch::Mechanism { what },
        ))
    }

    /// Entries of V that are given stay known where only others of their row become free.
    fn keep_declared_entries(
        &self,
        model: &mut Model,
        freed: &[(usize, usize)],
    ) -> Result<(), SetupError> {
        if freed.is_empty() {
            return Ok(());
        }
        let id = effect::COUPLING.id;
        for index in 0..model.parameters().len() {
            let parameter = &model.parameters()[index];
            let Role::Coupling { row, column } = parameter.role else {
                continue;
            };
            let estimated = self.settings.effects[row].iter().any(|e| e.id == id);
            if !estimated && !freed.contains(&(row, column)) {
                let value = parameter.value;
                model.fix(index, value).map_err(|e| at(&self.place, e))?;
            }
        }
        Ok(())
    }
}

/// Puts an effect behind others where it is not among them.
fn add(effects: &mut Vec<&'static Effect>, effect: &'static Effect) {
    if effects.iter().all(|e| e.id != effect.id) {
        effects.push(effect);
    }
}

/// Start of an entry of V that becomes free: any value other than zero puts it among the parameters.
const ENTRY_START: f64 = 1e-9;

fn with_entries(
    declared: Option<DMatrix<f64>>,
    freed: &[(usize, usize)],
    n: usize,
) -> Option<DMatrix<f64>> {
    if freed.is_empty() {
        return declared;
    }
    let mut matrix = declared.unwrap_or_else(|| DMatrix::identity(n, n));
    for &place in freed {
        if matrix[place] == 0.0 {
            matrix[place] = ENTRY_START;
        }
    }
    Some(matrix)
}

/// A load in the frame of a link.
fn on(link: usize) -> Payload {
    Payload {
        link,
        frame: nalgebra::Isometry3::identity(),
    }
}
