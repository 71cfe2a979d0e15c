/* Shared by the files view*.c, which draw the pictures of a drive. Only the world's thread uses it. */
#ifndef FURROW_RENDER_VIEW_H
#define FURROW_RENDER_VIEW_H

#include "render/render.h"
#include "base/key_map.h"
#include "base/key_set.h"
#include "render/imagery.h"

/* The tiles that the picture of one moment needs, most needed first. */
struct view_look {
	double time; /* simulated, s */
	double made; /* simulated time, s, at which this was computed */
	bool guessed; /* ranges were missing, so others were used in their place */
	uint64_t done; /* number of ranges that the look-ahead had loaded by then */
	size_t count;
	uint64_t keys[2 * RENDER_DRAWS_MAX];
	struct imagery_pages imagery; /* pages of imagery that it shows */
};

#define VIEW_LOOKS 4 /* number of future moments that are looked at */
#define VIEW_MISSING 1024

struct view_errors; /* view_errors.c */

/* A camera that writes frames. */
struct view_camera {
	const struct scene_camera *camera;
	struct render_screen *screen; /* one of view.screens, or the render's own */
	uint64_t frames;
	struct view_look ahead;       /* its next frame; `time` is in the past: none was looked at */
};

struct view_contact {
	bool known;       /* `low` and `high` bound the offsets that this contact leaves; false: only `reach` bounds them */
	double low, high; /* metres; low <= 0 <= high */
};

struct view {
	struct world *world;
	bool watched;             /* somebody watches every picture, as in a window */
	bool at_steps;            /* true: only every scene.view.images-th step has a picture; false: any step may have one */
	uint64_t frames;          /* pictures drawn */
	/* the scene's objects, the world's figures, and the bodies that a host has added; NULL: the scene's objects alone */
	struct scene_object *drawn;
	int32_t *added;           /* numbers of these bodies */
	size_t added_count;
	size_t bodies;            /* of the host's world when they were listed */
	struct render *render;
	struct render_imagery *imagery; /* NULL: pictures show none */
	struct key_set deformed;  /* tiles that had offsets, or a finer tile with offsets, before the drive; 11 to 21 bytes each */
	/* for each tile that this drive changed: bounds of the offsets that its contacts may have left */
	struct offset_bounds bounds;
	struct view_contact contact; /* what the current contact may leave */
	/* tiles that will be deformed, and all coarser tiles above them; empty except while looking ahead */
	struct key_set expected;
	struct key_cache ranges;  /* ranges of base heights; a is NaN: the tile has nothing to draw */
	double reach;             /* metres; bounds how far a contact with an unknown result may change the ground */
	struct view_errors *errors; /* NULL: distance alone decides the detail */
	size_t budget;            /* most slots that one picture may need */
	size_t budget_written;    /* the same of a picture that is written: objects do not act while it is drawn */
	bool complete;            /* the present selection is for a picture that waits for its tiles */
	size_t room;              /* most slots that this picture and the future ones may need together */
	/* true: missing ranges are read at once; false: the look-ahead's thread reads them, and other ranges are used meanwhile */
	bool exact;
	bool guessed;             /* the last selection used other ranges in place of missing ones */
	struct ground_range_key *missing; /* ranges to ask the look-ahead for, at most VIEW_MISSING */
	size_t missing_count;
	bool coarse;              /* the last selection had less detail, to fit the budget; only for figures */
	bool told;
	bool free;                /* a host has set the camera: */
	struct render_camera camera;
	struct render_sun sun;
	bool lacks;               /* the last picture lacked tiles that were not resident */
	struct render_selection *selection;
	struct view_look *now;    /* the last picture */
	struct view_look *ahead;  /* VIEW_LOOKS of them, replaced in turn */
	unsigned turn;
	struct view_camera *cameras;  /* the scene's cameras; none if the view is watched */
	size_t camera_count, camera_turn;
	struct render_screen *screens; /* of sizes that the render's own screen does not have; no two alike */
	size_t screen_count;
	struct key_set seen;      /* used while prefetch requests are collected */
	uint64_t naps;            /* pictures that waited for their tiles */
	double nap_ms;            /* time of these waits, without waits for the store, which are counted elsewhere */
	uint64_t starved;         /* frames drawn with less detail than asked for, for any reason */
	uint64_t coarsened;       /* frames among `starved` whose reason was the budget */
	double triangles;         /* summed over frames */
	struct render_tiles tiles; /* summed over frames */
	double overdraw;          /* summed over frames whose overdraw is known */
	uint64_t overdraw_frames;
	enum status failed;       /* status of a failed source callback */
};

/* view_camera.c */
/* Places the camera. If the view is not exact, nothing is waited for, and the camera's height may be wrong. */
void render_view_place_camera(struct view *view, double time, struct render_camera *camera);

/* Places a fixed camera, or one that follows a body. The same holds for its height. */
void render_view_aim(struct view *view, const struct scene_aim *aim, double time, struct render_camera *camera);
/* Returns the height of the undisturbed ground, m; `otherwise` where there is none. */
double render_view_ground_at(struct view *view, double x, double y, double otherwise);

/* view.c: the steps of a picture. */
/* Selects the tiles that the camera sees. `complete`: waits until all are resident. */
enum status render_view_find_tiles(struct view *view, const struct render_camera *camera, bool complete) FURROW_CHECKED;
/* Draws the shadows of the terrain that this camera may see, if the scene has them, and moves the sun before. Call it before
 * render_view_find_tiles. */
enum status render_view_shade(struct view *view, const struct render_camera *camera, bool complete) FURROW_CHECKED;
void render_view_count(struct view *view); /* counts the frame that was drawn */
void render_view_count_tiles(struct view *view); /* counts the tiles alone: the frame was drawn a second time */

void render_view_move_sun(struct view *view); /* view_sun.c: to where it is now */

/* view_cameras.c: cameras that write frames. */
enum status render_view_make_cameras(struct view *view) FURROW_CHECKED;
void render_view_free_cameras(struct view *view);
/* Looks at the next frame of one camera, in turn. Part of render_view_look_ahead. */
enum status render_view_look_camera(struct view *view) FURROW_CHECKED;

/* view_objects.c: finds the pose of an object now. *known: there is ground below it, or its path says its height. */
enum status render_view_object(struct view *view, size_t index, struct render_object *object, bool *known) FURROW_CHECKED;
/* view_objects.c: gives the picture the present places of objects. */
enum status render_view_set_objects(struct view *view) FURROW_CHECKED;

/* view_bodies.c: bodies of a host, which may add some at any time. Fills params->objects with all that may be drawn. */
enum status render_view_list_drawn(struct view *view, struct render_params *params) FURROW_CHECKED;
/* Finds where a body of this number is. Returns false if it was not placed, is gone, or follows a path. */
bool render_view_body(const struct view *view, size_t number, struct render_object *object);

/* view_ranges.c: ranges of tiles. If the exact range is missing, that of a coarser tile above is used. */
/* Returns true if this range is not in memory and must not be read now. It is then noted as missing, and the caller must use
 * another. */
bool render_view_lacks_range(struct view *view, enum ground_range_kind kind, struct tile tile);
/* Returns true if the range of this tile is in memory. */
bool render_view_has_range(struct view *view, enum ground_range_kind kind, struct tile tile);
/* Gives the missing ranges to the look-ahead, which reads them. */
void render_view_ask_ranges(struct view *view);
/* Notes missing ranges of tiles that contacts will change and that were deformed before the drive. */
void render_view_expect_contacts(struct view *view);

/* view_source.c */
void render_view_find_room(struct view *view);
/* Finds how far the triangles between a tile's posts are off the ground between them, metres; `tile` is of level 0 or below. If the view
 * is not exact, it may be 0 until the look-ahead has read the ground. */
enum status render_view_bend(struct view *view, struct tile tile, double *bend) FURROW_CHECKED;
/* Finds the lowest (a) and highest (b) base height of a tile, in metres; a is NaN: all is nodata. If the view is not exact, the
 * range may be that of a coarser tile above. */
enum status render_view_base_range(struct view *view, struct tile tile, struct key_pair *range) FURROW_CHECKED;
/* Adds a tile and all above it. */
enum status render_view_add_chain(const struct view *view, struct key_set *set, struct tile tile) FURROW_CHECKED;
/* Selects the tiles that `camera` sees, within the budget. `everything`: treats all tiles as not resident, so that `wanted` has
 * the whole picture. No tile counts as used. */
enum status render_view_select(struct view *view, const struct render_camera *camera, bool everything) FURROW_CHECKED;
/* The same for any view. */
enum status render_view_select_seen(struct view *view, const struct render_view *whole, bool everything) FURROW_CHECKED;
/* Marks the selected tiles as used. `stand_ins`: also those that are drawn in place of tiles that are not resident. */
void render_view_mark_used(struct view *view, bool stand_ins);

/* view_offsets.c: bounds of the offsets of a tile. */
bool render_view_is_deformed(const struct view *view, struct tile tile); /* the tile, or a finer tile below it, has offsets */
double render_view_find_reach(const struct world *world);
/* Finds the range of offsets that the store had at the drive's start, in metres; low <= 0 <= high. If the view is not exact,
 * the range may be that of a coarser tile above. */
enum status render_view_stored_offsets(struct view *view, struct tile tile, double *low, double *high) FURROW_CHECKED;
/* Called by render_view_contact. */
enum status render_view_offsets_contact(struct view *view, const struct contact_area *area) FURROW_CHECKED;
/* Notes that the current contact changes this tile of the working level. */
enum status render_view_offsets_touch(struct view *view, struct tile tile) FURROW_CHECKED;
/* Finds a range, in metres, that contains all offsets of the tile and of finer tiles below it. `expected`: also those that the
 * drive will have made by the future moment that is looked at. */
enum status render_view_offsets(struct view *view, struct tile tile, bool expected, double *low, double *high) FURROW_CHECKED;

/* view_errors.c: how much a drawn tile differs in height from the finest ground. Used only with a pixel error. */
enum status render_view_errors_create(const struct world *world, struct view_errors **out) FURROW_CHECKED;
void render_view_errors_destroy(struct view_errors *errors); /* errors may be NULL */
/* Called by render_view_contact. */
enum status render_view_errors_contact(struct view *view, const struct world_touch *touch) FURROW_CHECKED;
/* Notes that the current contact changes this tile of the working level. */
enum status render_view_errors_touch(struct view *view, struct tile tile) FURROW_CHECKED;
/* Gives the error in metres, for render_source.error. `expected`: the tile will be deformed by the future moment that is
 * looked at. */
enum status render_view_error(struct view *view, struct tile tile, bool expected, double *error) FURROW_CHECKED;

/* view_imagery.c: imagery. Each does nothing if pictures show none. */
enum status render_view_make_imagery(struct view *view) FURROW_CHECKED;
/* Puts the pages of imagery that a look's tiles show into the look. */
enum status render_view_look_imagery(struct view *view, const struct render_camera *camera, struct view_look *look) FURROW_CHECKED;
/* Requests pages for the looks that are ahead, and lets finished loads become resident. Call it once a step. */
enum status render_view_want_imagery(struct view *view) FURROW_CHECKED;

/* view_ahead.c: tiles that future pictures will need. */
void render_view_keep_now(struct view *view);
/* Sorts the looks by time, the soonest first, and returns their number. Those whose time has passed are left out. */
size_t render_view_order_ahead(const struct view *view, const struct view_look *order[VIEW_LOOKS + SCENE_CAMERAS]);
/* Fills the look with the tiles that the camera sees at its time, as if none were resident. `time`: when it is drawn. */
enum status render_view_look(struct view *view, const struct render_camera *camera, double time, struct view_look *look) FURROW_CHECKED;
/* Looks at one of the future moments. Call this once for each frame, after it was selected and kept. */
enum status render_view_look_ahead(struct view *view) FURROW_CHECKED;

#endif
