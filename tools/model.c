/* furrow model: what Furrow sees in the model of a vehicle, and how a scene would drive it. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "command.h"
#include "errors.h"
#include "json.h"
#include "scene/scene.h"
#include "screen.h"
#include "vehicle/vehicle.h"

#define NOTES_MOST 64
#define STEP "0.002" /* s: the time step to which notes and the model's own are compared */

static const struct command_option options[] = {
	{"model-path", "DIR", .help = "folder of packages and meshes that the model names", .files = "/", .repeats = true},
	{"fixed", "HELD", .help = "whether a root without a joint is held: true or false", .preset = "as the model says; a URDF is free"},
	{"json", .help = "one JSON object"},
	{.name = NULL},
};

/* --- loading --- */

static char *notes[NOTES_MOST];
static size_t note_count;

/* Returns a message without its beginning, which tells of the scene that this command made. */
static const char *own_text(const char *text)
{
	static const char of[] = "vehicles.model: ";
	text = scene_text_reason(text);
	return strncmp(text, of, strlen(of)) == 0 ? text + strlen(of) : text;
}

static void take_note(const char *text)
{
	text = own_text(text);
	if (note_count < NOTES_MOST && (notes[note_count] = mem_strdup(text)) != NULL)
		note_count++;
}

static void quote(FILE *stream, const char *text)
{
	fputc('"', stream);
	for (; *text != '\0'; text++)
		fprintf(stream, *text == '"' || *text == '\\' ? "\\%c" : "%c", *text);
	fputc('"', stream);
}

static enum status load_scene(const struct arguments *arguments, struct scene **scene)
{
	char *text = NULL;
	size_t length;
	const char *folder, *fixed = arguments_text(arguments, "fixed");
	FILE *stream = open_memstream(&text, &length);
	TRY_MEM(stream, "a scene");
	fputs("scene: 1\ntime_step: " STEP "\nend_time: 1\nsoil: {name: dry_sand}\nredistribute: {model: scm}\nvehicles:\n  - {name: model, model: ", stream);
	quote(stream, arguments_at(arguments, 0));
	fputs(", start: {at: [0, 0]", stream);
	if (fixed != NULL)
		fprintf(stream, ", fixed: %s", strcmp(fixed, "true") == 0 ? "true" : "false");
	fputs("}", stream);
	for (size_t i = 0; (folder = arguments_nth(arguments, "model-path", i)) != NULL; i++) {
		fputs(i == 0 ? ", model_path: [" : ", ", stream);
		quote(stream, folder);
	}
	fputs(arguments_text(arguments, "model-path") != NULL ? "]}\n" : "}\n", stream);
	if (fclose(stream) != 0) {
		free(text);
		return fail_memory("a scene");
	}
	enum status status = scene_load_text(text, NULL, NULL, 0, SCENE_COMMAND, scene);
	free(text);
	return status;
}

/* The scene of a model has no name and no lines that its user knows. */
static enum status fail_of_model(enum status status)
{
	char why[900];
	if (status != STATUS_INPUT || scene_text_reason(failure_message()) == failure_message())
		return status;
	snprintf(why, sizeof why, "%s", own_text(failure_message()));
	return fail_with(status, "model: %.880s", why);
}

/* --- how a scene would drive it --- */

static const char *role_name(enum vehicle_role role)
{
	static const char *const names[] = {[VEHICLE_ROLE_HOLDS] = "holds", [VEHICLE_ROLE_DRIVES] = "drives", [VEHICLE_ROLE_STEERS] = "steers", [VEHICLE_ROLE_FOLLOWS] = "follows"};
	return names[role];
}

static const char *driver_name(const struct vehicle_joint *joint)
{
	return joint->actuator != NULL ? joint->actuator : joint->name;
}

static size_t count_role(const struct vehicles *vehicles, size_t joints, enum vehicle_role role)
{
	size_t count = 0;
	struct vehicle_joint joint;
	for (size_t i = 0; i < joints; i++) {
		vehicle_part_joint(vehicles, 0, i, &joint);
		count += joint.role == role;
	}
	return count;
}

static void list_role(const struct vehicles *vehicles, size_t joints, enum vehicle_role role)
{
	struct vehicle_joint joint;
	bool any = false;
	for (size_t i = 0; i < joints; i++) {
		vehicle_part_joint(vehicles, 0, i, &joint);
		if (joint.role != role)
			continue;
		fputs(any ? ", " : "", stdout);
		screen_put(driver_name(&joint));
		any = true;
	}
}

/* Returns true if the axles of the wheels that drive look along x: the model looks along y. */
static bool looks_aside(const struct vehicles *vehicles, size_t joints)
{
	double along[2] = {0, 0};
	struct vehicle_joint joint;
	for (size_t i = 0; i < joints; i++) {
		vehicle_part_joint(vehicles, 0, i, &joint);
		for (int k = 0; k < 2 && joint.role == VEHICLE_ROLE_DRIVES; k++)
			along[k] += fabs(joint.axis[k]);
	}
	return along[0] > 3 * along[1];
}

static const char *kind_of(const struct vehicles *vehicles, const struct vehicle_info *info)
{
	struct vehicle_size size;
	vehicle_part_size(vehicles, 0, &size);
	if (count_role(vehicles, info->joint_count, VEHICLE_ROLE_DRIVES) > 0)
		return "wheels";
	return !size.free ? "held" : info->joint_count > 0 ? "limbs" : "body";
}

/* --- text --- */

static void print_joint(const struct vehicles *vehicles, size_t number)
{
	struct vehicle_joint joint;
	vehicle_part_joint(vehicles, 0, number, &joint);
	fputs("joint      ", stdout);
	screen_put(joint.name);
	printf(": %s, %s", joint.slides ? "a slide" : "a hinge", role_name(joint.role));
	if (joint.limited)
		printf(", %.4g to %.4g %s", joint.low, joint.high, joint.slides ? "m" : "rad");
	if (joint.wheel != NULL) {
		fputs(", wheel ", stdout);
		screen_put(joint.wheel);
		printf(" of %.4g m", joint.radius);
	}
	if (joint.actuator == NULL)
		fputs(", no actuator", stdout);
	putchar('\n');
}

static void print_text(const struct vehicles *vehicles, const char *path)
{
	struct vehicle_info info;
	struct vehicle_size size;
	vehicle_info(vehicles, 0, &info);
	vehicle_part_size(vehicles, 0, &size);
	printf("mass       %.6g kg in %zu bodies; read by %s\n", info.mass, size.bodies, vehicle_engine());
	printf("size       %.4g x %.4g x %.4g m of what touches: %zu soil geoms\n", size.high[0] - size.low[0], size.high[1] - size.low[1], size.high[2] - size.low[2],
	       info.geom_count);
	fputs("root       ", stdout);
	screen_put(size.root);
	puts(size.free ? ", which moves freely" : ", which is held, or slides along joints of the model");
	for (size_t i = 0; i < info.joint_count; i++)
		print_joint(vehicles, i);
	for (size_t i = 0; i < info.actuator_count; i++) {
		struct vehicle_actuator actuator;
		vehicle_part_actuator(vehicles, 0, i, &actuator);
		fputs("actuator   ", stdout);
		screen_put(actuator.name);
		printf(": asks for a %s", actuator.keeps);
		fputs(actuator.joint != NULL ? " of " : " of more than a joint", stdout);
		screen_put(actuator.joint != NULL ? actuator.joint : "");
		putchar('\n');
	}
	const char *keyframe;
	for (size_t i = 0; (keyframe = vehicle_part_keyframe(vehicles, 0, i)) != NULL; i++) {
		fputs("keyframe   ", stdout);
		screen_put(keyframe);
		putchar('\n');
	}
	for (size_t i = 0; i < note_count; i++) {
		fputs("note       ", stdout);
		screen_put(notes[i]);
		putchar('\n');
	}
	if (count_role(vehicles, info.joint_count, VEHICLE_ROLE_DRIVES) == 0) {
		puts("drives     on no path: no wheel on the ground turns about a hinge; give driver: {controls: FILE.csv}, or hold");
		return;
	}
	fputs("in a scene\n    vehicles:\n      - name: vehicle\n        model: ", stdout);
	screen_put(path);
	if (looks_aside(vehicles, info.joint_count))
		fputs("\n        forward: +y   # or -y: its axles look along x", stdout);
	fputs("\n        start: {at: [X, Y]}\n        driver: {path: {points: [[X, Y], [X, Y]], speed: 0.5}, drive: [", stdout);
	list_role(vehicles, info.joint_count, VEHICLE_ROLE_DRIVES);
	if (count_role(vehicles, info.joint_count, VEHICLE_ROLE_STEERS) > 0)
		fputs("], steer: [", stdout);
	list_role(vehicles, info.joint_count, VEHICLE_ROLE_STEERS);
	puts("]}");
}

/* --- JSON --- */

static void add_limits(cJSON *object, bool limited, double low, double high)
{
	if (limited)
		json_pair(object, "range", low, high);
	else
		cJSON_AddNullToObject(object, "range");
}

static void add_joint(cJSON *list, const struct vehicles *vehicles, size_t number)
{
	struct vehicle_joint joint;
	cJSON *object = cJSON_CreateObject();
	vehicle_part_joint(vehicles, 0, number, &joint);
	json_string(object, "name", joint.name);
	json_string(object, "type", joint.slides ? "slide" : "hinge");
	json_string(object, "role", role_name(joint.role));
	add_limits(object, joint.limited, joint.low, joint.high);
	json_number(object, "value", joint.value);
	cJSON_AddItemToObject(object, "axis", cJSON_CreateDoubleArray(joint.axis, 3));
	cJSON_AddItemToObject(object, "at", cJSON_CreateDoubleArray(joint.at, 3));
	json_string(object, "actuator", joint.actuator);
	json_string(object, "wheel", joint.wheel);
	if (joint.wheel != NULL)
		json_number(object, "radius", joint.radius);
	cJSON_AddItemToArray(list, object);
}

static void add_actuator(cJSON *list, const struct vehicles *vehicles, size_t number)
{
	struct vehicle_actuator actuator;
	cJSON *object = cJSON_CreateObject();
	vehicle_part_actuator(vehicles, 0, number, &actuator);
	json_string(object, "name", actuator.name);
	json_string(object, "joint", actuator.joint);
	json_string(object, "keeps", actuator.keeps);
	add_limits(object, actuator.limited, actuator.low, actuator.high);
	cJSON_AddItemToArray(list, object);
}

static enum status print_model(const struct vehicles *vehicles, const char *path)
{
	cJSON *root = cJSON_CreateObject();
	struct vehicle_info info;
	struct vehicle_size size;
	vehicle_info(vehicles, 0, &info);
	vehicle_part_size(vehicles, 0, &size);
	json_string(root, "model", path);
	json_string(root, "engine", vehicle_engine());
	json_string(root, "kind", kind_of(vehicles, &info));
	json_number(root, "mass", info.mass);
	json_integer(root, "bodies", (int64_t)size.bodies);
	json_integer(root, "soil_geoms", (int64_t)info.geom_count);
	json_string(root, "root", size.root);
	cJSON_AddBoolToObject(root, "free", size.free);
	cJSON_AddItemToObject(root, "low", cJSON_CreateDoubleArray(size.low, 3));
	cJSON_AddItemToObject(root, "high", cJSON_CreateDoubleArray(size.high, 3));
	json_string(root, "forward", looks_aside(vehicles, info.joint_count) ? "+y" : "+x");
	json_number(root, "largest_step", info.largest_step);
	cJSON *joints = cJSON_AddArrayToObject(root, "joints"), *actuators = cJSON_AddArrayToObject(root, "actuators");
	for (size_t i = 0; i < info.joint_count; i++)
		add_joint(joints, vehicles, i);
	for (size_t i = 0; i < info.actuator_count; i++)
		add_actuator(actuators, vehicles, i);
	cJSON *keyframes = cJSON_AddArrayToObject(root, "keyframes"), *told = cJSON_AddArrayToObject(root, "notes");
	const char *keyframe;
	for (size_t i = 0; (keyframe = vehicle_part_keyframe(vehicles, 0, i)) != NULL; i++)
		cJSON_AddItemToArray(keyframes, cJSON_CreateString(keyframe));
	for (size_t i = 0; i < note_count; i++)
		cJSON_AddItemToArray(told, cJSON_CreateString(notes[i]));
	return json_print(root);
}

static enum status run(const struct arguments *arguments)
{
	struct scene *scene = NULL;
	struct vehicles *vehicles = NULL;
	enum status status;
	const char *fixed = arguments_text(arguments, "fixed");
	if (fixed != NULL && strcmp(fixed, "true") != 0 && strcmp(fixed, "false") != 0)
		return fail_with(STATUS_USAGE, "model: --fixed is %.40s; give true or false", fixed);
	note_to(take_note);
	TRY_OR(done, load_scene(arguments, &scene));
	TRY_OR(done, vehicle_load(scene, &vehicles));
	if (arguments_flag(arguments, "json"))
		TRY_OR(done, print_model(vehicles, arguments_at(arguments, 0)));
	else
		print_text(vehicles, arguments_at(arguments, 0));
done:
	note_to(NULL);
	for (size_t i = 0; i < note_count; i++) {
		if (status != STATUS_OK)
			note("model: %s", notes[i]);
		mem_free(notes[i]);
	}
	vehicle_destroy(vehicles);
	scene_destroy(scene);
	return status == STATUS_OK ? STATUS_OK : fail_of_model(status);
}

const struct command command_model = {
	.name = "model",
	.summary = "what a vehicle's model has, and how a scene drives it",
	.arguments = COMMAND_ARGUMENTS({"MODEL", .help = "MJCF or URDF of a vehicle", .files = "xml urdf", .needed = true}),
	.options = options,
	.details = "Reads a model as a scene would, and tells its mass, size, joints, actuators and keyframes, with what was added, mended or left out. A joint drives "
		   "a wheel, steers above one, follows (a castor), or holds. The last lines are what a scene needs to drive it along a path.\n"
		   "\n"
		   "Nothing is driven, and no GL is needed.\n",
	.examples = "furrow model rover.urdf\nfurrow model robot/urdf/robot.urdf --model-path meshes --json\n",
	.see = "furrow-drive(1), furrow-explain(1), scene(5)",
	.run = run,
};
