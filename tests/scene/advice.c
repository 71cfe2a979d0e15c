/* Advice: each rule is told of a scene that asks for it, alone, and not of one beside it. */
#include <math.h>

#include "fixture.h"
#include "../support/program.h"
#include "../support/skip.h"

/* Nothing is to be said of it. */
static const char sound[] = "scene: 1\nend_time: 10\ntime_step: 0.1\n"
			    "objects:\n"
			    "  - {name: a, shape: {wheel: {radius: 1, width: 1}}, path: {points: [[0, 0], [30, 0]], speed: 3}}\n";
static const char looked_at[] = "scene: 1\nend_time: 10\ntime_step: 0.1\n"
				"view: {camera: {chase: a}, effects: [texture], images: 50}\n"
				"objects:\n"
				"  - {name: a, shape: {wheel: {radius: 1, width: 1}}, path: {points: [[0, 0], [30, 0]], speed: 3}}\n";
static const char still[] = "scene: 1\nend_time: 10\ntime_step: 0.1\n"
			    "view: {camera: {eye: [1, 2, 3], target: [0, 0, 0]}, images: 51}\n";
static const char soil[] = "scene: 1\nend_time: 10\ntime_step: 0.1\n"
			   "soil: {name: dry_sand}\n"
			   "redistribute: {model: scm}\n"
			   "objects:\n"
			   "  - {name: a, shape: {wheel: {radius: 1, width: 1}}, path: {points: [[0, 0], [30, 0]], speed: 3}}\n";
static const char heavy[] = "scene: 1\nend_time: 10\ntime_step: 0.1\n"
			    "soil: {name: snow_us}\n"
			    "redistribute: {model: scm}\n"
			    "objects:\n"
			    "  - {name: a, shape: {wheel: {radius: 0.3, width: 0.2}}, load: 600, path: {points: [[0, 0], [30, 0]], speed: 3}}\n";
static const char resting[] = "scene: 1\nend_time: 10\ntime_step: 0.1\n"
			      "objects:\n"
			      "  - {name: a, shape: {wheel: {radius: 1, width: 1}}, path: {points: [[5, 5]], speed: 3}}\n";

struct told {
	int count;
	char text[500];
};

static void hear(void *user, const char *text)
{
	struct told *told = user;
	told->count++;
	snprintf(told->text, sizeof told->text, "%s", text);
	assert_non_null(strstr(text, ": "));
	assert_non_null(strstr(text, "; "));
	assert_null(strchr(text, '\n'));
}

/* Up to three keys over a scene; `says`: the one line that begins with it; NULL: none. */
static void advised(const char *text, double spacing, const char *key, const char *value, const char *says)
{
	char keys[3][64], values[3][128];
	struct scene_setting settings[3];
	size_t count = 0;
	while (key != NULL && *key != '\0') {
		int k = (int)strcspn(key, "&"), v = (int)strcspn(value, "&");
		snprintf(keys[count], sizeof keys[count], "%.*s", k, key);
		snprintf(values[count], sizeof values[count], "%.*s", v, value);
		settings[count] = (struct scene_setting){keys[count], values[count]};
		count++;
		key += k + (key[k] == '&');
		value += v + (value[v] == '&');
	}
	struct scene *scene;
	struct told told = {.count = 0};
	if (load_text(text, settings, count, &scene) != STATUS_OK)
		fail_msg("%s", failure_message());
	scene_advise(scene, spacing, hear, &told);
	scene_destroy(scene);
	if (told.count != (says != NULL))
		fail_msg("%s: told %d times: %s", count > 0 ? keys[0] : "as it is", told.count, told.text);
	if (says != NULL && strncmp(told.text, says, strlen(says)) != 0)
		fail_msg("not \"%s\" but \"%s\"", says, told.text);
}

static void a_sound_scene_is_told_nothing(void **state)
{
	advised(sound, 0.5, NULL, NULL, NULL);
	advised(looked_at, 0.5, NULL, NULL, NULL);
	advised(still, 0.5, NULL, NULL, NULL);
	advised(soil, 0.5, NULL, NULL, NULL);
	advised(resting, 0.5, NULL, NULL, NULL);
}

static void times_that_lead_nowhere(void **state)
{
	advised(resting, 0.5, "time_step", "11", "time_step: 11 s is longer than the drive, 10 s: ");
	advised(resting, 0.5, "time_step", "10", NULL);
	advised(sound, 0.5, "end_time", "10.2", "end_time: the last object is at its path's end after 10 s, and nothing changes until 10.2 s; ");
	advised(sound, 0.5, "end_time", "10.1", NULL);
	advised(soil, 0.5, "end_time", "20", NULL); /* soil may slide on */
	advised(sound, 0.5, "end_time&objects.a.path.loop", "90&true", NULL);
	advised(sound, 0.5, "gravity", "1.62", "gravity: 1.62 m/s2 changes nothing: ");
	advised(sound, 0.5, "gravity", "9.81", NULL);
	advised(soil, 0.5, "gravity", "1.62", NULL); /* the soil weighs less */
	advised(soil, 0.5, "gravity&soil.unit_weight", "1.62&2500", "gravity: 1.62 m/s2 changes nothing: ");
	advised(soil, 0.5, "soil.density", "1500", NULL);
	advised(soil, 0.5, "soil.density&soil.unit_weight", "1600&15696", NULL);
	advised(soil, 0.5, "soil.density&soil.unit_weight", "1600&2500", "soil.density: the soil weighs its unit_weight, 2500 N/m3, not density x gravity, 15696; ");
}

static void what_is_of_objects_where_there_are_none(void **state)
{
	advised(still, 0.5, "coordinates", "store", "coordinates: are of paths, and there is none; ");
	advised(looked_at, 0.5, "coordinates", "store", NULL);
	advised(still, 0.5, "redistribute.model", "box", "redistribute.model: box moves the soil that objects press, and there is none; ");
	advised(looked_at, 0.5, "redistribute.model", "box", NULL);
	advised(still, 0.5, "outside", "skip", "outside: is of objects, and there is none; ");
	advised(looked_at, 0.5, "outside", "skip", NULL);
	advised(still, 0.5, "view.images", "50", "view.images: nothing moves: all of its 2 pictures are the same; one is enough, with end_time 5");
	advised(looked_at, 0.5, "view.images", "10", NULL);
	advised(still, 0.5, "attributes", "[disturbance]", NULL); /* what earlier drives left is seen */
}

static void what_the_ground_makes_nothing_of(void **state)
{
	write_text("soils.png", "any bytes");
	advised(soil, 0.5, "soil", "{map: soils.png, classes: {1: dry_sand, 2: dry_sand}, default: dry_sand}",
		"soil.map: all its classes are the default's soil; ");
	advised(soil, 0.5, "soil", "{map: soils.png, classes: {1: dry_sand, 2: lunar}, default: dry_sand}", NULL);
	unlink(in_folder("soils.png"));
	advised(resting, 0.5, "redistribute.model", "box", "redistribute.model: box smooths where an object leaves, and none moves; ");
	advised(sound, 0.5, "redistribute.model", "box", NULL);
	advised(soil, 0.5, "redistribute", "{model: scm, bulldozing: 0, iterations: 2}", "redistribute.iterations: no soil is laid ");
	advised(soil, 0.5, "redistribute", "{model: scm, bulldozing: 0}", NULL);
	advised(soil, 0.5, "redistribute", "{model: scm, bulldozing: 0, iterations: 2, depth: 1}", NULL);
	advised(soil, 0.5, "redistribute", "{model: scm, iterations: 2}", NULL);
	advised(heavy, 0.01, "redistribute", "{model: scm, depth: 0.1}", "redistribute.depth: 0.1 m is how deep soil slides, and no firm ground begins there: a sinks by about 0.21 m; ");
	advised(heavy, 0.01, "redistribute", "{model: scm, depth: 0.5}", NULL);
	advised(soil, 0.5, "redistribute.interval", "11", "redistribute.interval: 11 s is longer than the drive, 10 s: ");
	advised(soil, 0.5, "redistribute.interval", "10", NULL);
	advised(soil, 0.5, "redistribute", "{model: scm, undisturbed: slides}", "redistribute.undisturbed: slides, but none of it is loose ");
	advised(soil, 0.5, "redistribute", "{model: scm, undisturbed: slides, depth: 2}", NULL);
	advised(soil, 0.5, "redistribute", "{model: slippage, undisturbed: slides}", NULL);
	advised(sound, 0.5, "soil", "{name: mud}", "soil: model none does not depend on it; ");
	advised(soil, 0.5, "soil.theta_in&soil.unit_weight", "30&9000", "soil: model scm does not read theta_in; ");
	advised(soil, 0.5, "soil.repose", "30", NULL);
#define OWN "bekker_kc: 990, bekker_kphi: 1e6, bekker_n: 1, cohesion: 500, friction_angle: 30, janosi_shear: 0.02"
	advised(soil, 0.5, "soil&soil.name", "{" OWN "}&lete_sand", "soil.name: the scene's own numbers replace all that model scm reads of lete_sand, except "
							      "elastic_stiffness, damping, density, unit_weight, repose, but run.json names lete_sand; give {name: lete_sand} alone, or take the name away");
	advised(soil, 0.5, "soil", "{name: lete_sand, " OWN "}", NULL); /* as furrow fit-soil writes it */
	advised(soil, 0.5, "soil", "{" OWN "}", NULL);
	advised(soil, 0.5, "soil&soil.name", "{cohesion: 500, friction_angle: 30, janosi_shear: 0.02}&lete_sand", NULL);
	advised(soil, 0.5, "redistribute.model&soil", "slippage&{name: lunar, cohesion: 500, friction_angle: 30, unit_weight: 9000}",
		"soil.name: the scene's own numbers replace all that model slippage reads of lunar, but run.json names lunar; ");
	advised(soil, 0.5, "redistribute.model&soil", "slippage&{name: lunar, cohesion: 170, friction_angle: 35, unit_weight: 2500}", NULL); /* its own */
	advised(soil, 0.5, "redistribute.model&soil.repose", "slippage&30", "soil: model slippage does not read repose; ");
	advised(sound, 0.5, "attributes", "[disturbance]", "attributes.disturbance: no picture shows it: it is kept for query and for later drives that draw it, at 1 byte a post; ");
	advised(looked_at, 0.5, "attributes", "[disturbance]", NULL);
}

static void objects_that_the_posts_do_not_see(void **state)
{
	advised(sound, 1.01, NULL, NULL, "objects.a.shape: is 1 m across, and posts are 1.01 m apart: it can pass between them and leave nothing; ");
	advised(sound, 1, NULL, NULL, NULL);
	advised(sound, 0, "objects.a.shape.wheel.grousers", "128", NULL); /* where posts are is not known */
	advised(sound, 2.1, "objects.a.shape", "{sphere: {radius: 1}}", "objects.a.shape: is 2 m across");
	advised(sound, 1, "objects.a.shape", "{box: {size: [2, 0.9, 0.1]}}", "objects.a.shape: is 0.9 m across");
	advised(sound, 0.9, "objects.a.shape", "{box: {size: [2, 0.9, 0.1]}}", NULL);
	/* It goes on until it meets a post; standing it may be between them. */
	advised(sound, 1, "objects.a.shape", "{box: {size: [0.1, 1, 0.1]}}", NULL);
	advised(resting, 1, "objects.a.shape", "{box: {size: [0.1, 1, 0.1]}}", "objects.a.shape: is 0.1 m across");
	advised(sound, 1, "objects.a.shape.wheel.radius", "0.4", NULL);
	advised(resting, 1, "objects.a.shape.wheel.radius", "0.4", "objects.a.shape: is 0.8 m across");
	advised(soil, 0.5, "objects.a.shape.wheel.grousers&objects.a.slip", "7&-0.5", NULL); /* braked: they are farther apart */
	advised(soil, 0.5, "objects.a.shape.wheel.grousers&objects.a.slip", "6&0.5", "objects.a.shape.wheel.grousers: their prints are 0.524 m apart");
	advised(sound, 0.5, "objects.a.shape.wheel.grousers", "7", "objects.a.shape.wheel.grousers: their prints are 0.898 m apart, less than two posts ");
	advised(sound, 0.5, "objects.a.shape.wheel.grousers", "6", NULL);
	write_text("poses.csv", "11,0,0,5\n12,9,9,5\n");
	advised(sound, 0.5, "objects.a.path", "{file: poses.csv}", "objects.a.path: begins after 11 s, and the drive ends after 10 s: ");
	write_text("poses.csv", "9,0,0,5\n12,9,9,5\n");
	advised(sound, 0.5, "objects.a.path", "{file: poses.csv}", NULL);
	advised(sound, 0.5, "objects.a.path&objects.a.sink", "{file: poses.csv}&0.1", "objects.a.sink: its poses say z already; ");
	unlink(in_folder("poses.csv"));
	advised(resting, 0.5, "objects.a.path.loop", "true", "objects.a.path.loop: its points are one place: ");
	advised(sound, 0.5, "objects.a.path.loop", "true", NULL);
	advised(soil, 0.5, "objects.a.slip", "0.1", NULL);
	advised(soil, 0.5, "objects.a.interface.friction_angle", "20", "objects.a.interface: it changes forces alone, and none is computed; ");
	advised(soil, 0.01, "objects.a.interface.friction_angle&objects.a.load", "20&900", NULL);
	advised(soil, 0.5, "objects.a.interface.adhesion&output.forces", "200&1", NULL);
	advised(soil, 0.01, "objects.a.interface&objects.a.load", "{friction_angle: 28, adhesion: 1040}&900",
		"objects.a.interface: its surface is no weaker than the soil, which shears within itself: it changes nothing; ");
	advised(soil, 0.01, "objects.a.interface&objects.a.load", "{friction_angle: 28, adhesion: 1039}&900", NULL);
	advised(soil, 0.01, "objects.a.interface&objects.a.load", "{friction_angle: 27.9, adhesion: 1040}&900", NULL);
	advised(soil, 0.01, "objects.a.interface&objects.a.load", "{friction_angle: 30}&900", "objects.a.interface: its surface is no weaker ");
	write_text("soils.png", "any bytes");
	advised(soil, 0.01, "soil&objects.a.interface&objects.a.load",
		"{map: soils.png, classes: {1: lunar}, default: dry_sand}&{friction_angle: 30}&900", NULL);
	unlink(in_folder("soils.png"));
	advised(soil, 0.5, "objects.a.slip&objects.a.path.points", "0.1&[[1, 2], [1, 2]]", "objects.a.slip: a wheel or a belt that stands does not turn; ");
}

static void objects_that_are_alike_are_told_of_once(void **state)
{
	static const char four[] = "scene: 1\nend_time: 10\ntime_step: 0.1\n"
				   "objects:\n"
				   "  - {name: a, shape: {sphere: {radius: 1}}, path: {points: [[5, 5]], speed: 3}}\n"
				   "  - {name: b, shape: {wheel: {radius: 1, width: 0.5, grousers: 30}}, path: {points: [[5, 5]], speed: 3}}\n"
				   "  - {name: c, shape: {wheel: {radius: 1, width: 0.5, grousers: 30}}, path: {points: [[5, 5]], speed: 3}}\n"
				   "  - {name: d, shape: {wheel: {radius: 1, width: 0.5, grousers: 30}}, path: {points: [[5, 5]], speed: 3}}\n";
	advised(four, 0.5, NULL, NULL, "objects.b.shape.wheel.grousers: their prints are 0.209 m apart, as of 2 others, less than two posts of 0.5 m: ");
	static const char two[] = "scene: 1\nend_time: 10\ntime_step: 0.1\n"
				  "objects:\n"
				  "  - {name: a, shape: {sphere: {radius: 1}}, path: {points: [[5, 5]], speed: 3}}\n"
				  "  - {name: b, shape: {wheel: {radius: 1, width: 2}}, path: {points: [[5, 5]], speed: 3}}\n";
	advised(two, 2.5, NULL, NULL, "objects.a.shape: is 2 m across, as of 1 other, and posts are 2.5 m apart: ");
}

static void keep(void *user, const char *text)
{
	struct told *told = user;
	if (strstr(text, ": forces may be off by ") == NULL)
		return;
	told->count++;
	snprintf(told->text, sizeof told->text, "%s", text);
}

struct few_posts {
	double over, posts, finer;
	int here, there; /* percent; `here` 0: nothing was told */
};

/* What is told of forces under scm, of one object at most. */
static struct few_posts forces_told(const char *object, const char *more, double spacing)
{
	struct few_posts found = {.over = 0};
	struct told told = {.count = 0};
	struct scene *scene;
	char text[1024], apart[48];
	snprintf(text, sizeof text, "scene: 1\nend_time: 10\ntime_step: 0.1\nsoil: {name: dry_sand}\nredistribute: {model: scm}\n%sobjects:\n"
				    "  - {name: a, path: {points: [[0, 0], [30, 0]], speed: 3}, %s}\n",
		 more, object);
	if (load_text(text, NULL, 0, &scene) != STATUS_OK)
		fail_msg("%s", failure_message());
	scene_advise(scene, spacing, keep, &told);
	scene_destroy(scene);
	assert_in_range(told.count, 0, 1);
	if (told.count == 0)
		return found;
	if (sscanf(told.text, "objects.a.shape: the soil bears it over about %lf m, %lf posts: forces may be off by %*[a-z ]%d %% here; at %lf m by %d %%", &found.over,
		   &found.posts, &found.here, &found.finer, &found.there) != 5 &&
	    sscanf(told.text, "objects.a.shape: the soil bears it over about %lf m, %lf posts: forces may be off by %*[a-z ]%d %% here%47[^;]; at %lf m by %d %%", &found.over,
		   &found.posts, &found.here, apart, &found.finer, &found.there) != 6)
		fail_msg("%s", told.text);
	return found;
}

static void forces_where_few_posts_lie_below_an_object(void **state)
{
	static const char *const bodies[] = {"shape: {wheel: {radius: 0.32, width: 0.24}}, load: 1000", "shape: {sphere: {radius: 0.2}}, load: 300",
					     "shape: {box: {size: [0.4, 0.3, 0.3]}}, load: 300"};
	static const double overs[] = {0.1418, 0.0878, 0.3};
	for (int i = 0; i < 3; i++) {
		int before = 1000, told = 0;
		for (double spacing = 0.64; spacing > 0.0005; spacing /= 2) {
			const struct few_posts found = forces_told(bodies[i], "", spacing);
			assert_true(found.here == 0 || found.here > 2);
			assert_true(found.here <= before && found.here <= 100);
			before = found.here;
			if (found.here == 0)
				continue;
			told++;
			assert_true(fabs(found.over / overs[i] - 1) < 0.02 && fabs(found.posts * spacing / found.over - 1) < 0.06);
			assert_true(found.there < found.here && found.finer < spacing);
			assert_true(fabs(log2(spacing / found.finer) - round(log2(spacing / found.finer))) < 1e-9);
			/* The finer spacing's own figure is that which was promised. */
			const struct few_posts there = forces_told(bodies[i], "", found.finer);
			assert_true(there.here == (there.here > 0 ? found.there : 0));
		}
		assert_int_equal(before, 0); /* nothing is told of fine posts */
		assert_true(told >= 2);
	}
	/* Where posts are, how the object touches the soil, or the forces are not known. */
	assert_int_equal(forces_told(bodies[0], "", 0).here, 0);
	assert_int_equal(forces_told("shape: {wheel: {radius: 0.32, width: 0.24}}", "output: {forces: 1}\n", 0.1).here, 0);
	assert_int_equal(forces_told("shape: {wheel: {radius: 0.32, width: 0.24}}, sink: 0.04", "", 0.1).here, 0);
	/* Its sink says as much as its load. The narrower of two wheels is further off, and so is one that sinks less. */
	const struct few_posts sunk = forces_told("shape: {wheel: {radius: 0.32, width: 0.24}}, sink: 0.04", "output: {forces: 1}\n", 0.1);
	assert_true(sunk.here > 2 && fabs(sunk.over - 0.08 * 0.28 / sqrt(0.04 * 0.6)) < 0.006);
	assert_true(forces_told("shape: {wheel: {radius: 0.32, width: 0.05}}, load: 200", "", 0.1).here > sunk.here);
	assert_true(fabs(forces_told("shape: {wheel: {radius: 0.32, width: 0.05}}, load: 200", "", 0.1).over - 0.05) < 1e-9);
	assert_true(forces_told("shape: {wheel: {radius: 0.32, width: 0.24}}, load: 50", "", 0.1).over < 0.5 * sunk.over);
	advised(soil, 0.5, "redistribute.model&objects.a.sink", "slippage&0.1", NULL); /* no model of forces */
}

static void rows_that_repeat(void **state)
{
	advised(soil, 0.5, "output.forces", "6", NULL);
	advised(soil, 0.5, "output.forces", "6.5", "output.forces: 6.5 rows a second, and no object comes to more than 6 posts in one: ");
	advised(soil, 0.5, "output.forces", "0.09", "output.forces: a row every 11.11 s, and the drive ends after 10 s: ");
	advised(soil, 0.5, "output.forces", "0.1", NULL);
	advised(soil, 0.5, "output.forces&objects.a.path.points", "1&[[1, 2]]", "output.forces: no object moves: ");
	write_text("poses.csv", "5,10,0\n"); /* and before that there is none of it */
	advised(soil, 0.5, "output.forces&objects.a.path", "1&{file: poses.csv}", NULL);
	write_text("poses.csv", "0,0,0\n5,10,0\n10,20,0\n");
	advised(soil, 0.5, "output.forces&objects.a.path", "4&{file: poses.csv}", NULL);
	advised(soil, 0.5, "output.forces&objects.a.path", "5&{file: poses.csv}", "output.forces: 5 rows a second");
	write_text("poses.csv", "0,0,0,0,0,0,0\n5,10,0,0,90,0,0\n10,20,0,0,0,0,0\n"); /* it turns too */
	advised(soil, 0.5, "output.forces&objects.a.path", "5&{file: poses.csv}", NULL);
	unlink(in_folder("poses.csv"));
}

/* A wheel of a vehicle of 900 kg. */
static void a_rebound_that_decides_the_resistance(void **state)
{
	static const char keys[] = "soil&objects.a&output.forces";
	static const char wheel[] = "{name: a, shape: {wheel: {radius: 0.35, width: 0.22}}, load: 2207, path: {points: [[0, 0], [30, 0]], speed: 3}}";
	char values[300];
	/* Furrow's rig: 2.3 of 18.1 mm, and 193 N instead of 312 N. */
	snprintf(values, sizeof values, "{name: sandy_loam_15}&%s&1", wheel);
	advised(soil, 0, keys, values, "soil.elastic_stiffness: is not given, so it is 4e+07 Pa/m: below objects.a the soil springs back by about 2.3 of 17 mm, and "
				       "pushes it from behind: the resistance is about 40 % less than in soil that does not spring back; ");
	snprintf(values, sizeof values, "{name: sandy_loam_15, elastic_stiffness: 4.0e7}&%s&1", wheel);
	advised(soil, 0, keys, values, NULL);
	snprintf(values, sizeof values, "{name: sandy_loam_15}&%s&0", wheel); /* nobody asks for forces */
	advised(soil, 0, keys, values, NULL);
	snprintf(values, sizeof values, "{name: lunar}&%s&1", wheel); /* it springs back less */
	advised(soil, 0, keys, values, NULL);
}

static void pictures_that_nobody_sees(void **state)
{
	advised(looked_at, 0.5, "view.images", "0", "view: no picture is written, so a drive draws none; ");
	advised(looked_at, 0.5, "view.images", "101", "view.images: one every 101 steps, and the drive ends after 100: none is written; ");
	advised(looked_at, 0.5, "view.images", "100", NULL);
	advised(looked_at, 0.5, "view.effects", "[objects, shadow]", NULL);
	advised(looked_at, 0.5, "view.effects", "[shadow]", "view.effects.shadow: is that of the objects, which are not drawn; ");
	advised(still, 0.5, "view.effects", "[objects]", "view.effects.objects: draws objects, and there is none; ");
	advised(still, 0.5, "view.effects", "[shadow]", "view.effects.shadow: is that of objects, and there is none; ");
	advised(looked_at, 0.5, "view.effects", "[detail]", "view.effects.detail: is the grain of the texture, which is not drawn; ");
	advised(looked_at, 0.5, "view.effects", "[detail, texture]", NULL);
	advised(looked_at, 0.5, "view.effects", "[fog]", NULL);
	advised(looked_at, 0.5, "view.effects&view.body", "[fog]&moon", "view.effects.fog: there is no air on the Moon: ");
	advised(looked_at, 0.5, "view.effects&view.body", "[fog]&mars", NULL);
	advised(looked_at, 0.5, "view.effects", "[splat]", "view.effects.splat: is of the texture, which is not drawn; ");
	advised(looked_at, 0.5, "view.effects", "[splat, texture]", "view.effects.splat: shows the classes of a map of soils, and there is none; ");
}

#define CAMERA(images) "[{name: c, kind: overhead, on: a, height: 8, rate: 1, images: [" images "]}]"

static void cameras_whose_mesh_leaves_out_ruts(void **state)
{
	static const char rough[] = "{roughness: 0.01, wavelength: 2}", coarse[] = "cameras.c: over relief its numbers are those of a mesh that leaves out shorter waves, up to about 0.02 m high";
	char text[256], says[256];
	advised(sound, 0.5, "cameras", CAMERA("depth"), "cameras.c: with the distance its mesh gets coarser than the posts, and narrow ruts are ");
	advised(sound, 0.5, "cameras", CAMERA("class, height"), "cameras.c: with the distance its mesh ");
	advised(sound, 0.5, "cameras", CAMERA("colour, class"), NULL);
	advised(looked_at, 0.5, "cameras&view.pixel_error", CAMERA("normals") "&1", NULL);
	advised(still, 0.5, "cameras", "[{name: c, kind: fixed, pose: {at: [1, 2, 3]}, rate: 1, images: [depth]}]", NULL);
	/* Over relief that is told along. */
	snprintf(text, sizeof text, "%s&%s", CAMERA("depth"), rough);
	snprintf(says, sizeof says, "%s, and narrow ruts; ", coarse);
	advised(sound, 0.125, "cameras&relief", text, says);
	snprintf(text, sizeof text, "%s&%s&1", CAMERA("depth"), rough);
	snprintf(says, sizeof says, "%s; ", coarse);
	advised(looked_at, 0.125, "cameras&relief&view.pixel_error", text, says);
}

static void a_cache_that_reads_nothing_ahead(void **state)
{
	advised(sound, 0.5, "cache.loaders", "0", "cache.prefetch: without loaders no tile is read ahead");
	advised(sound, 0.5, "cache", "{loaders: 0, prefetch: 0}", NULL);
	advised(sound, 0.5, "cache.prefetch", "0", "cache.prefetch: 0: a drive waits for each tile that it comes to; give seconds of travel, as 1.5");
	advised(still, 0.5, "cache.prefetch", "0", NULL);
	advised(resting, 0.5, "cache.prefetch", "0", NULL); /* it comes to none */
}

/* The scenes handed out, at their own spacing: what is said of them is meant. */
static void the_examples_are_told_what_they_mean(void **state)
{
	static const struct {
		const char *name, *says;
	} examples[] = {
		{"bare", NULL},   {"convoy", NULL}, {"demo", NULL},  {"foot", NULL},
		{"shapes", NULL}, {"tracks", NULL},
		{"rover", "objects.front_left.shape: the soil bears it over about 0.061 m, as 5 others, 2 posts: forces may be off by about "},
		{"table2", "view: no picture is written, so a drive draws none; "},
	};
	const char *scenes = getenv("SCENES");
	if (scenes == NULL)
		skip_since("the scenes that ship are not named");
	for (size_t i = 0; i < sizeof examples / sizeof examples[0]; i++) {
		char path[1024];
		struct scene *scene;
		struct told told = {.count = 0};
		snprintf(path, sizeof path, "%s/%s.yaml", scenes, examples[i].name);
		if (scene_load(path, NULL, 0, &scene) != STATUS_OK) {
			assert_says("this build reads no meshes");
			continue;
		}
		scene_advise(scene, scene->spacing > 0 ? scene->spacing : 0.25, hear, &told);
		scene_destroy(scene);
		if (told.count != (examples[i].says != NULL) ||
		    (told.count > 0 && strncmp(told.text, examples[i].says, strlen(examples[i].says)) != 0))
			fail_msg("%s is told %d things: %s", examples[i].name, told.count, told.text);
	}
}

TEST_PROGRAM(advice)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_sound_scene_is_told_nothing),
		cmocka_unit_test(times_that_lead_nowhere),
		cmocka_unit_test(what_is_of_objects_where_there_are_none),
		cmocka_unit_test(what_the_ground_makes_nothing_of),
		cmocka_unit_test(objects_that_the_posts_do_not_see),
		cmocka_unit_test(objects_that_are_alike_are_told_of_once),
		cmocka_unit_test(forces_where_few_posts_lie_below_an_object),
		cmocka_unit_test(rows_that_repeat),
		cmocka_unit_test(a_rebound_that_decides_the_resistance),
		cmocka_unit_test(pictures_that_nobody_sees),
		cmocka_unit_test(cameras_whose_mesh_leaves_out_ruts),
		cmocka_unit_test(a_cache_that_reads_nothing_ahead),
		cmocka_unit_test(the_examples_are_told_what_they_mean),
	};
	return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
