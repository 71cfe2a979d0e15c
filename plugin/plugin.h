/* What the files of the engine plugin share. One thread at a time uses a mjData, and so what is its own here. */
#ifndef FURROW_PLUGIN_H
#define FURROW_PLUGIN_H

#include <mujoco/mujoco.h>

#include "api/furrow_mujoco.h"

#include <stdbool.h>

/* Functions of the host's MuJoCo: host.c finds them in the library that is loaded already. Behind this header their names mean those. */
#define PLUGIN_EACH(CALL) \
	CALL(mj_version) CALL(mj_versionString) CALL(mjp_defaultPlugin) CALL(mjp_registerPlugin) CALL(mj_getPluginConfig) CALL(mju_error) CALL(mju_warning) \
	CALL(mj_kinematics) CALL(mj_comPos) CALL(mj_makeM) CALL(mj_factorM) CALL(mj_solveM) CALL(mj_rne) CALL(mj_referenceConstraint) CALL(mj_projectConstraint) \
	CALL(mj_fwdActuation) CALL(mj_fwdAcceleration) CALL(mj_fwdConstraint) CALL(mj_name2id) CALL(mj_id2name)

struct plugin_host {
#define PLUGIN_MEMBER(name) __typeof__(&name) name;
	PLUGIN_EACH(PLUGIN_MEMBER)
#undef PLUGIN_MEMBER
};
extern struct plugin_host plugin_host; /* constant once the library is loaded */

/* The soil under one mjData. */
struct plugin_soil {
	struct furrow_world *world;
	struct furrow_mujoco *soil;
	char *overlay;          /* the path that no other mjData of this process may have; NULL: it has a folder of its own, */
	char *folder;           /* which goes away with it */
	int count;              /* soil geoms; */
	int *geoms;             /* their numbers in the model */
	double *forces, *passive, *end, *damping, *mass; /* nv, nv, nv, nv, nC */
	bool used, moved;       /* since the last reset: it was computed; a step was made */
	bool fresh, computed;   /* since the last step: it was not computed; it was */
	bool foreign;           /* mj_copyData brought a state whose ground is another one */
	double base, until, start; /* s: time of the present step's start, of the last step's end, and of the first step's start after a reset */
	struct plugin_field *field, *skin; /* NULL: no height field, no skin follows the ground */
};

/* Fails, as MuJoCo does: its mju_error with one line, which does not return. */
void plugin_fail(const char *format, ...) __attribute__((format(printf, 1, 2)));
void plugin_must(furrow_status status); /* the same with the library's message, unless the status is FURROW_OK */

/* --- files.c: which overlay a mjData writes --- */
/* Sets soil->overlay: to `asked` unless another mjData of this process has it; then, and for NULL, to a file in a folder of its own. Returns false if there is none:
 * no folder can be made, or memory is short. */
bool plugin_take_overlay(struct plugin_soil *soil, const char *asked);
void plugin_give_overlay(struct plugin_soil *soil);

/* --- sensors.c --- */
int plugin_sensor_size(const mjModel *model, int instance, int sensor);
void plugin_sense(const mjModel *model, mjData *data, int instance, const struct plugin_soil *soil);
/* Returns what is wrong with the sensors of an instance; NULL: nothing. */
const char *plugin_check_sensors(const mjModel *model, int instance, const struct plugin_soil *soil);

/* --- field.c: a height field and a skin that follow the ground --- */
/* Makes soil->field and soil->skin. Makes none without its key, `hfield` or `skin`, or if another mjData of the same model has it already. Returns what is wrong;
 * NULL: nothing. */
const char *plugin_make_fields(const mjModel *model, int instance, struct plugin_soil *soil, const double origin[3]);
void plugin_free_field(struct plugin_field *field); /* takes NULL */
/* Brings them up to date, at most some times in a second of simulated time. `all`: now, and everywhere. */
void plugin_follow(const mjModel *model, const struct plugin_soil *soil, bool all);

#ifndef PLUGIN_FINDS
#define mj_version (*plugin_host.mj_version)
#define mj_versionString (*plugin_host.mj_versionString)
#define mjp_defaultPlugin (*plugin_host.mjp_defaultPlugin)
#define mjp_registerPlugin (*plugin_host.mjp_registerPlugin)
#define mj_getPluginConfig (*plugin_host.mj_getPluginConfig)
#define mju_error (*plugin_host.mju_error)
#define mju_warning (*plugin_host.mju_warning)
#define mj_kinematics (*plugin_host.mj_kinematics)
#define mj_comPos (*plugin_host.mj_comPos)
#define mj_makeM (*plugin_host.mj_makeM)
#define mj_factorM (*plugin_host.mj_factorM)
#define mj_solveM (*plugin_host.mj_solveM)
#define mj_rne (*plugin_host.mj_rne)
#define mj_referenceConstraint (*plugin_host.mj_referenceConstraint)
#define mj_projectConstraint (*plugin_host.mj_projectConstraint)
#define mj_fwdActuation (*plugin_host.mj_fwdActuation)
#define mj_fwdAcceleration (*plugin_host.mj_fwdAcceleration)
#define mj_fwdConstraint (*plugin_host.mj_fwdConstraint)
#define mj_name2id (*plugin_host.mj_name2id)
#define mj_id2name (*plugin_host.mj_id2name)
#endif

#endif
