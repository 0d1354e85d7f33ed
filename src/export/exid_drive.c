/* The actuator plugin: `ctrl` holds the signals of the motors, or the positions that their controllers are told, and
   `actuator_force` becomes the torques of the drives.

   Friction near standstill, stiff gears and flanks of teeth are stiffer than a simulator's step, so the drives act with
   the velocity at the end of the step: v+ = v + h M^-1 (free + F(q + h v+, v+)), which Newton's method solves. Contacts
   and limits do not take part in this forecast, and the motion that results differs by them alone. */

/* The number of a key in a text of the configuration, whatever the locale; an error for what is none. */
static double exid_number(int key, const char *text) {
    const exid_setting *of = &exid_settings[key];
    char word[64] = "", *end = word;
    if (!text || !*text)
        mju_error("exid.drive: config has no key \"%s\" (joint %s): give it, with a number as its value", exid_keys[key], of->joint);
    if (strlen(text) < sizeof word && strspn(text, " \t\r\n+-.0123456789eE") == strlen(text)) strcpy(word, text);
    char *point = strchr(word, '.');
    if (point) *point = *localeconv()->decimal_point;
    const double number = strtod(word, &end);
    const int is_read = end != word && end[strspn(end, " \t\r\n")] == 0;
    if (!is_read || !isfinite(number))
        mju_error("exid.drive: value \"%.80s\" of config key \"%s\" (joint %s) is no number: give one in SI units, such as 0.25",
                  text, exid_keys[key], of->joint);
    if (number < of->least || number > of->greatest)
        mju_error("exid.drive: value \"%.80s\" of config key \"%s\" (joint %s) is not one of its law: give one from %g to %g", text,
                  exid_keys[key], of->joint, of->least, of->greatest);
    return number;
}

static int exid_actuators(const mjModel *m, int instance, int *found) {
    int count = 0;
    for (int i = 0; i < m->nu; i++)
        if (m->actuator_plugin[i] == instance && m->actuator_trntype[i] == mjTRN_JOINT) {
            if (count < EXID_JOINTS) found[count] = i;
            count++;
        }
    return count;
}

/* What a step from here to the velocity `next` misses; torques go to `force`, what the drives remember to `after`. */
typedef struct {
    const double *values;
    double h, before[EXID_STATES], ctrl[EXID_JOINTS], q[EXID_JOINTS], v[EXID_JOINTS], free[EXID_JOINTS];
    double inverse[EXID_JOINTS * EXID_JOINTS];
} exid_step;

static void exid_miss(const exid_step *of, const double *next, double *force, double *after, double *out) {
    double q[EXID_JOINTS], a[EXID_JOINTS], signal[EXID_JOINTS];
    for (int j = 0; j < EXID_JOINTS; j++) {
        q[j] = of->q[j] + of->h * next[j];
        a[j] = (next[j] - of->v[j]) / of->h;
    }
    for (int k = 0; k < EXID_STATES; k++) after[k] = of->before[k];
    exid_signals(of->values, of->ctrl, q, next, signal);
    exid_drive_step(of->values, after, of->h, signal, q, next, a, force);
    for (int j = 0; j < EXID_JOINTS; j++) {
        double acceleration = of->free[j];
        for (int k = 0; k < EXID_JOINTS; k++) acceleration += of->inverse[j * EXID_JOINTS + k] * force[k];
        out[j] = next[j] - of->v[j] - of->h * acceleration;
    }
}

/* What an actuator is given, as late as its `delay` says. */
static double exid_ctrl(const mjModel *m, const mjData *d, int actuator) {
#ifdef EXID_HELD_BACK
    mjtNum interpolated;
    const mjtNum *kept = mj_readCtrl(m, d, actuator, d->time, &interpolated, 1);
    return kept ? *kept : interpolated;
#else
    (void)m;
    return d->ctrl[actuator];
#endif
}

static void exid_compute(const mjModel *m, mjData *d, int instance, int capability) {
    int actuator[EXID_JOINTS], dof[EXID_JOINTS];
    exid_step of;
    mjtNum *held = d->plugin_state + m->plugin_stateadr[instance];
    (void)capability;
    exid_actuators(m, instance, actuator);
    of.values = (const double *)d->plugin_data[instance];
    of.h = m->opt.timestep;
    mj_markStack(d);
    mjtNum *right = mj_stackAllocNum(d, m->nv), *solution = mj_stackAllocNum(d, m->nv);
    for (int i = 0; i < m->nv; i++) right[i] = d->qfrc_passive[i] - d->qfrc_bias[i] + d->qfrc_applied[i];
    mj_solveM(m, d, solution, right, 1);
    for (int j = 0; j < EXID_JOINTS; j++) {
        const int joint = m->actuator_trnid[2 * actuator[j]];
        dof[j] = m->jnt_dofadr[joint];
        of.q[j] = d->qpos[m->jnt_qposadr[joint]];
        of.v[j] = d->qvel[dof[j]];
        of.free[j] = solution[dof[j]];
        of.ctrl[j] = exid_ctrl(m, d, actuator[j]);
    }
    for (int k = 0; k < EXID_JOINTS; k++) {
        mju_zero(right, m->nv);
        right[dof[k]] = 1.0;
        mj_solveM(m, d, solution, right, 1);
        for (int j = 0; j < EXID_JOINTS; j++) of.inverse[j * EXID_JOINTS + k] = solution[dof[j]];
    }
    mj_freeStack(d);
    for (int k = 0; k < EXID_STATES; k++) of.before[k] = held[k];
    if (of.before[1] < 0.5) {
        double unused[EXID_JOINTS], signal[EXID_JOINTS], at_rest[EXID_JOINTS] = {0.0};
        exid_signals(of.values, of.ctrl, of.q, of.v, signal);
        exid_drive_step(of.values, of.before, of.h, signal, of.q, of.v, at_rest, unused);
    }
    double next[EXID_JOINTS], moved[EXID_JOINTS], force[EXID_JOINTS], tried_force[EXID_JOINTS];
    double after[EXID_STATES], tried_after[EXID_STATES];
    double miss[EXID_JOINTS], tried[EXID_JOINTS], step[EXID_JOINTS], slopes[EXID_JOINTS * EXID_JOINTS];
    for (int j = 0; j < EXID_JOINTS; j++) next[j] = of.v[j];
    exid_miss(&of, next, force, after, miss);
    for (int newton = 0; newton < 40; newton++) {
        for (int c = 0; c < EXID_JOINTS; c++) {
            for (int k = 0; k < EXID_JOINTS; k++) moved[k] = next[k];
            moved[c] += EXID_SPEED_CHANGE;
            exid_miss(&of, moved, tried_force, tried_after, tried);
            for (int k = 0; k < EXID_JOINTS; k++)
                slopes[k * EXID_JOINTS + c] = (tried[k] - miss[k]) / EXID_SPEED_CHANGE;
        }
        for (int k = 0; k < EXID_JOINTS; k++) step[k] = miss[k];
        solve(EXID_JOINTS, slopes, step);
        double share = 1.0;
        int closer = 0;
        for (int halving = 0; halving < 20 && !closer; halving++) {
            for (int k = 0; k < EXID_JOINTS; k++) moved[k] = next[k] - share * step[k];
            exid_miss(&of, moved, tried_force, tried_after, tried);
            closer = squares(EXID_JOINTS, tried) < squares(EXID_JOINTS, miss);
            share *= 0.5;
        }
        if (!closer) break;
        for (int k = 0; k < EXID_JOINTS; k++) {
            next[k] = moved[k];
            miss[k] = tried[k];
            force[k] = tried_force[k];
        }
        for (int k = 0; k < EXID_STATES; k++) after[k] = tried_after[k];
        if (squares(EXID_JOINTS, step) < 1e-22) break;
    }
    for (int j = 0; j < EXID_JOINTS; j++) d->actuator_force[actuator[j]] = force[j];
    for (int k = 0; k < EXID_STATES; k++) held[EXID_STATES + k] = after[k];
}

static int exid_nstate(const mjModel *m, int instance) {
    (void)m, (void)instance;
    return 2 * EXID_STATES;
}

static int exid_init(const mjModel *m, mjData *d, int instance) {
    int actuator[EXID_JOINTS];
    double read[EXID_VALUES] = {0.0};
    if (exid_actuators(m, instance, actuator) != EXID_JOINTS)
        mju_error("exid.drive: the instance has not %d actuators: give it one per joint, in the order of the joints in model.xml",
                  EXID_JOINTS);
    for (int key = 0; key < EXID_SETTINGS; key++)
        read[exid_settings[key].place] = exid_number(key, mj_getPluginConfig(m, instance, exid_keys[key]));
    const char *wrong = exid_derive(read);
    if (wrong) mju_error("exid.drive: %s: mend the values of config", wrong);
    double *values = (double *)malloc(sizeof read);
    if (!values) return -1;
    memcpy(values, read, sizeof read);
    d->plugin_data[instance] = (uintptr_t)values;
    return 0;
}

static void exid_destroy(mjData *d, int instance) {
    free((void *)d->plugin_data[instance]);
    d->plugin_data[instance] = 0;
}

static void exid_reset(const mjModel *m, mjtNum *state, void *data, int instance) {
    (void)m, (void)data, (void)instance;
    for (int k = 0; k < 2 * EXID_STATES; k++) state[k] = 0.0;
}

static void exid_advance(const mjModel *m, mjData *d, int instance) {
    mjtNum *held = d->plugin_state + m->plugin_stateadr[instance];
    for (int k = 0; k < EXID_STATES; k++) held[k] = held[EXID_STATES + k];
}

mjPLUGIN_LIB_INIT(exid_drive) {
    mjpPlugin plugin;
    mjp_defaultPlugin(&plugin);
    plugin.name = "exid.drive";
    plugin.nattribute = EXID_SETTINGS;
    plugin.attributes = exid_keys;
    plugin.capabilityflags = mjPLUGIN_ACTUATOR;
    plugin.nstate = exid_nstate;
    plugin.init = exid_init;
    plugin.destroy = exid_destroy;
    plugin.reset = exid_reset;
    plugin.compute = exid_compute;
    plugin.advance = exid_advance;
    mjp_registerPlugin(&plugin);
}
