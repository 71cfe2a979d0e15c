/*
 * report: what a run did and what it used: run.json, objects.csv and map.png. And before a run, its plan: the resources it will
 * make and the passes it will run.
 *
 * All of it is for the world's thread. It reads the world and does not change it.
 */
#ifndef FURROW_REPORT_H
#define FURROW_REPORT_H

#include <stdio.h>

#include "base/base.h"
#include "base/times.h"
#include "render/render.h"
#include "vehicle/vehicle.h"
#include "world/world.h"

struct cJSON;
struct report_poses;

/* What a run's own loop measured. */
struct report {
	const struct world *world;
	const struct view *view;         /* NULL: there is no view, or nobody asked for a picture of it */
	struct pictures *pictures;       /* NULL: none are written */
	const struct report_poses *poses; /* of cameras; NULL: none */
	const struct vehicles *vehicles; /* NULL: there are none */
	bool advised;                    /* a drive: run.json has all notes on its scene; of a host only those on units */
	struct times step_ms;            /* without drawing */
	struct times picture_ms;         /* of each picture alone, without the step that it follows; empty if none is drawn */
	struct stalls stalls_settled;    /* in the first second of the loop; complete once `settled` */
	bool settled;
	double warm_seconds;             /* wall clock until the loop began */
	unsigned threads;                /* threads that ran when the last step was over */
	double seconds;                  /* wall clock of the loop */
	double processor;                /* s of all threads, from the first step until the last is over; the last commit comes after it */
};

/* Returns the text of run.json, to free with mem_free. `ended`: "complete", "interrupted" or "failed". NULL: out of memory. */
char *report_json(const struct report *report, const char *ended);
/* Puts what `ranks` ranks did together into the text of run.json that rank 0 made: volume, loads that were not carried, and "ranks". */
enum status report_gathered(char **json, const struct world_ranked *ranked, int ranks) FURROW_CHECKED;
/* Writes DIRECTORY/run.json, under another name first, then renamed. */
enum status report_write(const char *directory, const char *json) FURROW_CHECKED;
/* Draws the map of the run so far, from what is committed. Writes it under another name first, then renames it. `vehicles`: NULL:
 * there are none. */
enum status report_map(const struct world *world, const struct vehicles *vehicles, const char *path, const char *ended) FURROW_CHECKED;
/* Checks before a drive that the map which the scene asks for (output.map) can be drawn. STATUS_INPUT: this build draws none, or there is no
 * font. Looks for fonts only if the scene asks. */
enum status report_map_check(const struct scene *scene) FURROW_CHECKED;

/* asked.c: tells of each object of whose path samples more than 1 % had no ground. Of many processes: nothing, since none has all samples. */
void report_groundless(const struct world *world, scene_advice_fn tell, void *user);
/* told.c: tells report_groundless, bodies that touched nothing in this run, pictures that are black, and report_slow_pictures. Call it when all pictures are
 * in their files. */
void report_end_notes(const struct report *report, scene_advice_fn tell, void *user);
/* Tells if pictures took most of the time: 5 s or more, and 20 times as long as the steps. Names what draws most pixels. */
void report_slow_pictures(const struct scene *scene, const struct times *steps, const struct times *pictures, scene_advice_fn tell, void *user);
/* failed.c: tells how often loads were not carried, or not held on a slope, and which object most, where and when first. Adds that object to
 * run.json's "forces". `sunk`, `slid`: how often in the whole drive. */
void report_failed(struct cJSON *forces, const struct world *world, int64_t sunk, int64_t slid);
/* asked.c: adds what was run: the program's version, the scene with all its settings, the store, the trace, and the notes. */
void report_asked(struct cJSON *root, const struct report *report);
/* counts.c: adds what was made and run. `gpu`: passes, without those of warming up. */
void report_counts(struct cJSON *root, const struct report *report, const struct gpu_stats *gpu, const struct resident_pages_io *io);
/* Numbers of tiles that a run keeps in memory. */
struct report_tiles {
	uint32_t slots, changed, ground; /* slots; images of changed pages, of queue_few; base heights on the CPU */
	uint32_t queries;                /* tiles that queries keep; 0: none are asked */
};
/* Adds the most bytes that tiles take, the number of tiles that they are computed from, and the memory that there is. */
void report_most(struct cJSON *memory, const char *name, const struct resident_pages_budget *most);
void report_tile_counts(struct cJSON *memory, const struct report_tiles *tiles);
void report_usable(struct cJSON *memory, const struct mem_usable *usable);
struct report_tiles report_tiles_of(const struct world *world, const struct resident_pages_budget *most);
/* where.c: adds where effects were computed, and where they might have been. */
void report_where(struct cJSON *root, const struct report *report, const struct gpu_stats *gpu);

/* --- the sun --- */

/* Degrees: clockwise from the store's north, and above the horizon. */
struct report_sun_place {
	double azimuth, height;
	double mean_hours, solar_hours; /* on Mars, with a time: local mean and local true solar time, hours of 1/24 sol; else NAN */
};
struct report_sun {
	bool drawn;              /* the scene has pictures or cameras. Otherwise the rest is not filled */
	struct render_sun sun;
	struct report_sun_place begins, ends; /* at the drive's beginning, and at end_time */
};
/* Needs the world's store or its assumed extent, no GL. STATUS_INPUT: the scene gives a time, and where the store is is not known. */
enum status report_sun_find(const struct world *world, struct report_sun *out) FURROW_CHECKED;
struct report_sun_place report_sun_at(const struct report_sun *sun, double time);
void report_sun_add(struct cJSON *root, const struct report_sun *sun); /* adds "sun", if there is one */
/* Tells if the sun is below the horizon in a part of the drive. */
void report_sun_advise(const struct world *world, scene_advice_fn tell, void *user);
/* Tells cameras that see nothing at first. A fixed one is below the ground, or off the terrain. One on an object is below the soil when the drive
 * begins. The ground is as it was imported. Without a store it tells nothing. */
void report_cameras_advise(const struct world *world, scene_advice_fn tell, void *user);

/* --- frame_cost.c: what pictures will cost, by a table that a bench wrote: processor seconds of software GL (llvmpipe), within a factor of
 * about three. On a GPU they cost less. Pure. --- */
double report_camera_seconds(const struct scene *scene, const struct scene_camera *camera); /* returns those of a frame */
double report_view_seconds(const struct scene *scene); /* returns those of a picture of the view; 0: it writes none */
int64_t report_camera_frames(const struct scene *scene, const struct scene_camera *camera, int64_t steps); /* returns the frames of so many steps */
/* Returns those of all pictures of so many steps. *count: their number. */
double report_pictures_seconds(const struct scene *scene, int64_t steps, int64_t *count);
void report_seconds_text(double seconds, char text[32]); /* with a unit, as "12 min" */
/* Tells if keys of the view make pictures three times as long, or longer, and all take half a minute or more. */
void report_pictures_advise(const struct scene *scene, int64_t steps, scene_advice_fn tell, void *user);

/* --- objects.csv --- */

struct report_rows;
/* Opens DIRECTORY/objects.csv. A new run starts the file. A resumed run cuts it to the rows it goes on from. *out is NULL if
 * the scene asks for no rows; then the file of another run is removed. `directory` must outlive the rows. */
enum status report_rows_open(const struct world *world, const char *directory, struct report_rows **out) FURROW_CHECKED;
void report_rows_close(struct report_rows *rows); /* takes NULL */
/* Writes rows of the world, in their order. Does nothing for NULL, as the next two. */
enum status report_rows_write(const struct report_rows *rows, const struct world_row *list, size_t count) FURROW_CHECKED;
/* Tells the end of the file, to which report_rows_rollback cuts it. */
enum status report_rows_mark(const struct report_rows *rows, int64_t *end) FURROW_CHECKED;
enum status report_rows_rollback(const struct report_rows *rows, int64_t end) FURROW_CHECKED;

/* --- vehicles.csv --- */

struct report_vehicles;
/* Opens DIRECTORY/vehicles.csv, as report_rows_open opens objects.csv. */
enum status report_vehicles_open(const struct world *world, struct vehicles *vehicles, const char *directory,
				 struct report_vehicles **out) FURROW_CHECKED;
void report_vehicles_close(struct report_vehicles *rows); /* takes NULL */
/* Writes the rows that are due at the present time. Does nothing for NULL. */
enum status report_vehicles_write(const struct report_vehicles *rows) FURROW_CHECKED;
/* Tells the end of the file, to which report_vehicles_rollback cuts it. Both do nothing for NULL. */
enum status report_vehicles_mark(const struct report_vehicles *rows, int64_t *end) FURROW_CHECKED;
enum status report_vehicles_rollback(const struct report_vehicles *rows, int64_t end) FURROW_CHECKED;

/* --- sensors.csv --- */

struct report_sensors;
/* Opens DIRECTORY/sensors.csv, as report_rows_open opens objects.csv, and writes DIRECTORY/sensors.json. */
enum status report_sensors_open(const struct world *world, struct vehicles *vehicles, const char *directory, struct report_sensors **out) FURROW_CHECKED;
void report_sensors_close(struct report_sensors *rows); /* takes NULL */
/* Writes the rows that are due at the present time. The other two are as those of vehicles.csv. All three do nothing for NULL. */
enum status report_sensors_write(const struct report_sensors *rows, const struct world *world) FURROW_CHECKED;
enum status report_sensors_mark(const struct report_sensors *rows, int64_t *end) FURROW_CHECKED;
enum status report_sensors_rollback(const struct report_sensors *rows, int64_t end) FURROW_CHECKED;

/* --- lidars --- */

#define REPORT_LIDARS "lidars" /* folder with a folder for each */
struct report_lidars;
/* Makes the folders of the scene's lidars, and opens their files. *out is NULL if there are none. `vehicles` may be NULL. */
enum status report_lidars_open(struct world *world, struct vehicles *vehicles, const char *directory, struct report_lidars **out) FURROW_CHECKED;
void report_lidars_close(struct report_lidars *lidars); /* takes NULL */
/* Measures and writes the frames that are due after the present step. It changes no result. Does nothing for NULL. */
enum status report_lidars_write(struct report_lidars *lidars) FURROW_CHECKED;

/* --- volume.csv --- */

/* Opens DIRECTORY/volume.csv, as report_rows_open opens objects.csv, and has the pages write it. *out is NULL if nothing is deformed, or the world
 * is one of many ranks. Close it when the world has stopped. */
enum status report_volume_open(const struct world *world, const char *directory, FILE **out) FURROW_CHECKED;

/* --- cameras --- */

/* Takes the poses of frames into DIRECTORY/cameras/NAME/poses.tum, whose folder exists. A resumed run goes on with the rows that it
 * finds. *out is NULL if the scene has no cameras. `directory` must outlive it. */
enum status report_poses_open(const struct world *world, const char *directory, struct report_poses **out) FURROW_CHECKED;
void report_poses_close(struct report_poses *poses); /* takes NULL */
const struct render_poses *report_poses_sink(const struct report_poses *poses); /* NULL for NULL */
/* Writes camera.json, and COLMAP's cameras.txt, images.txt and points3D.txt, of each camera. Takes NULL. */
enum status report_cameras(const struct report_poses *poses) FURROW_CHECKED;
/* Adds "cameras" to run.json: what each is, how many frames it has written, and where it was at the first and the last. Frames are those of the
 * whole drive. `poses` NULL: they are not known. */
void report_cameras_add(struct cJSON *root, const struct scene *scene, const struct report_poses *poses);
/* Makes colour.mp4 of the cameras that ask for a video, with ffmpeg. Waits for it. Call it when all pictures are in their files. A video
 * that cannot be made is noted. Takes NULL. */
void report_videos(const struct report_poses *poses);

/* --- the plan --- */

/*
 * What a run will make and run, found before it begins. Needs no GL, makes no thread, and changes nothing, not even the store.
 *
 * Amounts that depend on the distance travelled (windows, tiles, commits) are in the plan by unit. Fixed numbers are in this struct. A run of
 * the same scene over the same store makes exactly what the plan says, times the counts of its units.
 */
struct report_body {
	const char *name;
	const struct soil_shape *shape;
	double over;          /* metres over which the soil bears it; 0: not known */
	double contacts;      /* of a soil geom: contacts a metre, as vehicle_geom tells it. -1: a hull. 0: an object of the scene */
};
struct report_plan {
	struct plan plan;
	uint64_t effects;     /* world_effects() */
	char *store;          /* path; NULL: none was given or found. Then the members below are assumed: */
	char *missing;        /* path of the store that the scene names, if that file is missing; else NULL */
	uint32_t cells;       /* on a tile's side; assumed 256 */
	int level;            /* the working level; assumed 0 */
	double spacing;       /* metres between posts of that level; assumed the scene's, or 1 */
	bool deformed;        /* the store is deformed before the run; assumed false */
	struct resident_pages_budget most; /* bytes, as memory.budget of run.json: planes in slots, and tiles on the host */
	struct report_tiles tiles; /* that `most` is computed from */
	struct mem_usable usable;  /* memory of this machine, or less; `most.queue` is within it */
	bool all;             /* every tile has a slot, so none is loaded ahead */
	bool bearing;         /* the CPU computes the ground, and tiles are kept in its memory */
	size_t window_tiles;  /* most tiles that one window, or one block of relaxing soil, can touch */
	size_t batch_windows; /* most contacts that are computed together; 0: each is computed alone */
	uint64_t batch_bytes; /* of GPU memory for that, beside what a contact needs that is alone */
	int64_t steps, pictures; /* until end_time; `pictures`: pictures drawn, which are those that are written */
	int64_t picture_steps; /* steps from one written picture to the next; 0: none is written */
	uint64_t *samples;   /* path samples of each object, until end_time */
	struct report_body *bodies; /* what the plan's lines call objects: those of the scene, then soil geoms of vehicles */
	size_t body_count;
	struct world_raster rasters[SOIL_RASTERS]; /* as the store's posts get them. Paths are the scene's */
	int raster_count;     /* 0: there is none, or no store */
	struct rocks_spec rocks; /* cover 0: none */
	double rocks_count;   /* about how many there are on the terrain; NAN: no store */
	/* Of what lies along the paths of objects and drivers, shares of 1: */
	bool soils_known;     /* false: no path, or no store and a map */
	double soils[SOIL_CLASSES];     /* of each soil */
	double unmapped;      /* where the map of soils has no value, so that the default soil is there */
	double covered[SOIL_RASTERS]; /* where each raster has a number */
	size_t places;        /* that were looked at */
	struct vehicles *vehicles; /* loaded; NULL: there are none */
	struct report_sun sun;
	char **notes;         /* texts of scene_advise, and those about the store: "KEY: WHY; WHAT TO DO" */
	size_t note_count;
};

/* Makes a plan. `store`: path that overrides the scene's; NULL: the scene's store, if that file exists. `keep_history`: the drive
 * is to keep one. Fails where a drive could not begin. STATUS_INPUT: the store or its spacing does not allow the scene. On failure
 * `out` is all zero. */
enum status report_plan(const struct scene *scene, const char *store, bool keep_history, struct report_plan *out) FURROW_CHECKED;
/* Does the checks of report_plan, and makes no plan. `store`: NULL: the scene's own. */
enum status report_check(const struct scene *scene, const char *store) FURROW_CHECKED;
/* objects.csv: all its columns, and whether a name is one of them that holds numbers. */
const char *report_objects_columns(void);
bool report_objects_column(const char *name);
void report_plan_finish(struct report_plan *plan); /* also takes one that is all zero */

#endif
