/* MuJoCo and the plugin, as a user's C program has them: the library is opened, and loads the plugin. A model's ground is level, or as a test says. */
#ifndef FURROW_TESTS_ENGINE_H
#define FURROW_TESTS_ENGINE_H

#define VEHICLE_MUJOCO_LOADS /* its functions by their own names are not those of src/vehicle */
#include "vehicle_mujoco.h"

#include <dlfcn.h>
#include <math.h>
#include <setjmp.h>

#include "../support/program.h"
#include "support.h"

#define ENGINE_CALLS(CALL) \
	CALL(mj_loadPluginLibrary) CALL(mj_parseXMLString) CALL(mj_compile) CALL(mjs_getError) CALL(mj_deleteSpec) CALL(mj_deleteModel) CALL(mj_makeData) CALL(mj_deleteData) \
	CALL(mj_step) CALL(mj_step1) CALL(mj_step2) CALL(mj_forward) CALL(mj_resetData) CALL(mj_copyData) CALL(mj_name2id) CALL(mj_fullM) CALL(mj_factorM)

static struct {
#define ENGINE_MEMBER(name) __typeof__(&name) name;
	ENGINE_CALLS(ENGINE_MEMBER)
#undef ENGINE_MEMBER
} engine;

static jmp_buf engine_back;
static char engine_error[1024]; /* MuJoCo's last error, once engine_catches */
static _Bool engine_catches;
static char engine_warning[1024]; /* MuJoCo's last warning */

static void engine_warn(const char *text)
{
	snprintf(engine_warning, sizeof engine_warning, "%s", text);
}

static void engine_fail(const char *text)
{
	snprintf(engine_error, sizeof engine_error, "%s", text);
	if (engine_catches)
		longjmp(engine_back, 1);
	print_error("MuJoCo: %s\n", text);
	exit(1);
}

/* Makes steps until one ends in an error, `most` of them at most. Returns MuJoCo's text; "": none did. */
static inline const char *engine_refuses(mjModel *model, mjData *data, int most)
{
	engine_error[0] = '\0';
	engine_catches = 1;
	if (setjmp(engine_back) == 0)
		for (int i = 0; i < most; i++)
			engine.mj_step(model, data);
	engine_catches = 0;
	return engine_error;
}

/* For cmocka's group: opens a folder, MuJoCo, and the plugin. */
static inline int engine_enter(void **state)
{
	void *library = dlopen(VEHICLE_MUJOCO_BUILT, RTLD_NOW | RTLD_LOCAL);
	if (library == NULL || support_enter(state) != 0)
		return -1;
#define ENGINE_FIND(name) *(void **)&engine.name = dlsym(library, #name);
	ENGINE_CALLS(ENGINE_FIND)
#undef ENGINE_FIND
	void (**error)(const char *) = dlsym(library, "mju_user_error");
	*error = engine_fail;
	*(void (**)(const char *))dlsym(library, "mju_user_warning") = engine_warn;
	engine.mj_loadPluginLibrary(getenv("FURROW_PLUGIN"));
	return 0;
}

#define ENGINE_SCENE "{scene: 1, spacing: 0.0625, soil: {name: dry_sand}, redistribute: {model: scm}}"

/* The four lines of MJCF. `more`: further keys. */
static inline const char *engine_extension(const char *geoms, const char *more)
{
	static char text[2048];
	snprintf(text, sizeof text,
		 "<extension><plugin plugin=\"furrow.soil\"><instance name=\"ground\"><config key=\"scene\" value=\"" ENGINE_SCENE "\"/>"
		 "<config key=\"store\" value=\"%s\"/><config key=\"geoms\" value=\"%s\"/><config key=\"origin\" value=\"10 10.5\"/>%s</instance></plugin></extension>",
		 support_path("ground.furrow"), geoms, more);
	return text;
}

/* NULL: it was refused, and engine_error says why. */
static inline mjModel *engine_model(const char *xml)
{
	char error[1024] = "";
	mjSpec *spec = engine.mj_parseXMLString(xml, NULL, error, sizeof error);
	if (spec == NULL) {
		snprintf(engine_error, sizeof engine_error, "%s", error);
		return NULL;
	}
	mjModel *model = engine.mj_compile(spec, NULL);
	if (model == NULL) /* what a plugin refuses comes as the compiler's error */
		snprintf(engine_error, sizeof engine_error, "%s", engine.mjs_getError(spec));
	engine.mj_deleteSpec(spec);
	return model;
}

/* The same, of a model that must not be refused. */
static inline mjModel *engine_accepted(const char *xml)
{
	mjModel *model = engine_model(xml);
	if (model == NULL)
		print_error("%s\n", engine_error);
	assert_non_null(model);
	return model;
}

/* A ball of 20 kg, r 0.2 m, 5 cm above the ground. */
static inline mjModel *engine_ball(const char *option, const char *more, const char *world, const char *sensors)
{
	char xml[8192];
	snprintf(xml, sizeof xml,
		 "<mujoco><option gravity=\"0 0 -9.81\" %s/>%s<worldbody>%s<body name=\"ball\" pos=\"0 0 0.25\"><freejoint/><plugin plugin=\"furrow.soil\" instance=\"ground\"/>"
		 "<geom name=\"ball\" type=\"sphere\" size=\"0.2\" mass=\"20\"/></body></worldbody>%s</mujoco>",
		 option, engine_extension("ball", more), world, sensors);
	return engine_model(xml);
}

#define ENGINE_SENSOR "<sensor><plugin plugin=\"furrow.soil\" instance=\"ground\" objtype=\"geom\" objname=\"%s\"/></sensor>"

static inline void engine_run(const mjModel *model, mjData *data, double seconds)
{
	const long count = lround(seconds / model->opt.timestep);
	for (long i = 0; i < count; i++)
		engine.mj_step(model, data);
}

static const struct extent engine_extent = {129, 129, 0.25, 32};

static inline double engine_level(int64_t x, int64_t y)
{
	(void)x, (void)y;
	return 0;
}

static inline void engine_store(void)
{
	if (access(support_path("ground.furrow"), F_OK) != 0)
		support_store(support_path("ground.furrow"), engine_extent, engine_level);
}

#endif
