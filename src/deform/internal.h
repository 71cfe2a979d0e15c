/* What the files of deform share. */
#ifndef FURROW_DEFORM_INTERNAL_H
#define FURROW_DEFORM_INTERNAL_H

#include "deform/deform.h"
#include "deform/programs.h"

#define SIDE DEFORM_WINDOW_POSTS
#define UNDER_NONE INT32_MAX /* lib/window.glsl: the object is not above the post */

/* FBOs over one layer of the scratch; those that the parameters do not call for are NULL. */
enum scratch_target {
	TO_UNDER,   /* under, rest */
	TO_PRESSED, /* what the model's press writes */
	TO_FIRST,   /* box: offset plane 0 */
	TO_SECOND,  /* the same, 1 */
	TO_BEGUN,   /* sliding: offset plane 0, heights, and what else it begins with */
	TO_HEIGHTS_0, TO_HEIGHTS_1,
	TO_SHED,    /* sumner: what is shed, where `carried` was */
	TO_SLID,    /* offset plane 1, and what slides with it */
	TO_DIRT,    /* disturbance plane 1 */
	TO_HELD,    /* contacts alone */
	TO_BARE,    /* nothing: images and buffers */
	SCRATCH_TARGETS
};

/* The scratch of one window. */
struct layer {
	struct gpu_target *to[SCRATCH_TARGETS];
	int now[PLANES]; /* which of planes[0 .. 1][plane] holds the result so far */
	bool alone;      /* the window is all of its contact */
	bool loaded;     /* the object may turn out to stand elsewhere */
	bool above;      /* the contact's */
	bool flagged;    /* its sliding says where something still moves */
};

struct deform;

struct slide_soil;
struct slide_place;

/* One way in which soil slides: soil/slide.c. A model that conserves soil names one. */
struct soil_slide {
	const char *effect; /* its name */
	int pass_count;     /* passes of one iteration, in which soil depends on posts as many posts away */
	enum slide_what passes[2];
	bool bounded;       /* the soil that can relax may have a bottom */
	bool held_still;    /* soil below an object does not slide */
	/* Computes what follows from a soil's numbers. */
	void (*prepare)(const struct deform *deform, const struct deform_soil *soil, struct slide_soil *to);
	enum status (*iterate)(struct deform *deform, const struct slide_place *place, int iteration);
};
extern const struct soil_slide deform_slide_excess; /* part of what exceeds the critical difference slides */
extern const struct soil_slide deform_slide_shed;   /* Sumner's: steep posts shed soil, by roughness */

/* Differences of heights that stand, axial and diagonal, fixed-point units. */
struct slide_soil {
	int32_t stands[2];
	int32_t held[2], stop[2]; /* sumner: beside a held post; where all are within these nothing slides. Its three have the
				   * tolerance in them */
	uint32_t share[8];        /* sumner: of 2^32, for 1 .. 8 neighbours */
};

struct deform {
	struct deform_params params;
	unsigned planes; /* deform_planes() */
	double spacing;
	int64_t reach;  /* posts beyond the footprint that change */
	int64_t border; /* posts beyond those that are read */
	uint32_t layers; /* that the textures have */
	struct gpu_texture *bases;
	struct gpu_texture *under, *rest;      /* rest NULL: nobody asks */
	struct gpu_texture *contacts;          /* PRESSED, HELD; NULL: nobody asks */
	struct gpu_texture *carried, *deposits; /* conserving models: fixed-point units, before and after deform_spread */
	struct gpu_texture *heights[2], *stills, *floors; /* while it slides; floors NULL: all soil is loose */
	struct gpu_texture *classes;           /* of soil; NULL: there is but one */
	struct gpu_texture *planes_of[2][PLANES]; /* [0] is gathered into, or what deform_gathers_into says */
	struct layer scratch[DEFORM_WINDOWS_MAX + 1]; /* [layers]: the atlas of blocks, of models that conserve */
	struct awake *awake;                   /* NULL: of others */
	struct interval *interval;
	struct gpu_program *under_program[2 * DEFORM_SHAPES]; /* made when first needed, as all of them */
	struct gpu_program *box, *press, *dirt, *spread;
	struct gpu_program *held[2];           /* [by load] */
	struct gpu_program *facet;
	struct facets *facets;                 /* meshes' and grousers': made when first needed */
	struct gpu_program *slide_begin[2][2]; /* [over blocks][by load] */
	struct gpu_program *slide[2][2], *shed[2]; /* [over blocks][last iteration] */
	struct slide_soil soils[DEFORM_SOILS];
	bool sweeps_flag;                      /* what a contact looked at says all about what moves after it */
	struct gpu_program *scm[8], *find[4]; /* by their defines, as bits */
	struct forces *forces;                /* NULL until a contact asks */
	struct gpu_buffer *tries;             /* of load.c; NULL until a contact needs it */
	struct gpu_buffer *standing;          /* int32 a loaded body: fixed-point units above its pose; NULL: there are none */
	struct gpu_buffer *tally;              /* struct deform_tally */
	struct gpu_buffer *felt;               /* the same, of contacts of which only the forces count; NULL until one does */
	struct deform_figures figures;         /* window_layers: see `layers` */
	uint64_t warmed;                       /* the kinds of objects that were (warm.c) */
};


int deform_gathers_into(const struct deform *deform, int plane);

/* scratch.c: textures and targets for `layers` windows. */
enum status deform_need_layers(struct deform *deform, uint32_t layers) FURROW_CHECKED;
void deform_drop_layers(struct deform *deform);
void deform_scratch_plan(const struct deform_params *params, struct plan *plan);

/* What follows from the parameters. */
bool deform_needs_contacts(const struct deform_params *params); /* scratch.c */
bool deform_has_classes(const struct deform_params *params);
int deform_soil_slots(const struct deform_params *params); /* soil/slide.c: classes of soil that a shader's parameters have room for */
bool deform_is_bounded(const struct deform_params *params);
bool deform_is_steep(const struct deform_params *params);
bool deform_asks_what_stood(const struct deform_params *params); /* undisturbed ground stands */
int deform_slide_passes(const struct deform_params *params);
int64_t deform_reach(const struct deform_params *params);  /* windows.c: struct deform's reach and border */
int64_t deform_border(const struct deform_params *params);
int64_t deform_core(const struct deform_params *params);   /* posts of a window that are written, at most */

/* A program by its place: made when first asked for. */
enum status deform_program(struct deform *deform, const struct deform_request *request,
			   struct gpu_program **place) FURROW_CHECKED;

/* Lines of memory, of all objects: a buffer, or staging. */
void deform_plan_buffer(struct plan *plan, const char *effect, int64_t amount, uint64_t bytes, const char *name);

/* std140 twins of what most passes over a window begin with. */
struct window_params {
	int32_t window[4]; /* posts in x and y; the layer */
};
struct press_params {
	uint32_t zero[4];   /* lo, hi: the window's zero height, fixed-point units from the store's reference; the layer */
	int32_t written[4]; /* the posts this window writes: first, one behind the last */
};
struct press_params deform_press_params(const struct deform *deform, const struct deform_sweep *sweep,
					const struct deform_window *window, uint32_t layer);
struct window_params deform_window_params(struct post_rect read, uint32_t layer);

/* The written posts, in the window's layer. */
struct gpu_rect deform_written(const struct deform_window *window);
/* All of them. */
struct gpu_rect deform_window_rect(const struct deform_window *window);

/* underside.c: the object over the window, into `under` and `rest`. */
enum status deform_underside(struct deform *deform, const struct deform_sweep *sweep,
			     const struct deform_window *window, uint32_t layer) FURROW_CHECKED;

/* facets.c: the lowest of triangles in motion over the window, into `under` and `rest` by minimum. Begun, added to and
 * ended for one window at a time. */
struct facet;
enum status deform_facets_begin(struct deform *deform, struct post_rect read, uint32_t layer) FURROW_CHECKED;
/* Room for one more; it counts once it is kept. */
struct facet *deform_facets_next(struct deform *deform);
void deform_facets_keep(struct deform *deform);
void deform_facets_end(struct deform *deform);
void deform_facets_plan(const char *effect, struct plan *plan);
void deform_facets_destroy(struct facets *facets);

/* mesh.c: a mesh over the window; and what its vertices say of it. */
enum status deform_mesh(struct deform *deform, const struct deform_sweep *sweep, const struct deform_window *window,
			uint32_t layer) FURROW_CHECKED;
double deform_mesh_reach(const struct deform_mesh *mesh, double pitch, double roll);

/* lugs.c: a wheel's grousers over the window, where the smooth wheel was drawn. */
enum status deform_lugs(struct deform *deform, const struct deform_sweep *sweep, const struct deform_window *window,
			uint32_t layer) FURROW_CHECKED;

/* stages.c: the press of a model that fills TO_PRESSED; its parameters begin with press_params. */
enum status deform_press(struct deform *deform, const void *params, size_t params_bytes,
			 const struct deform_window *window, uint32_t layer) FURROW_CHECKED;

/* stages.c: a press whose parameters are press_params alone. */
enum status deform_contact_plainly(struct deform *deform, const struct deform_sweep *sweep, const struct deform_window *window,
				 uint32_t layer) FURROW_CHECKED;
/* soil/slide.c: what follows a press that carried soil away. */
enum status deform_spread_and_slide(struct deform *deform, const struct deform_window *window, uint32_t layer) FURROW_CHECKED;

/* std140 twin of lib/soil.glsl's block. */
struct scm_soil {
	float a[4], b[4];
};
struct scm_params {
	int32_t zero[4], written[4], shadow[4];
	float scale[4], way[4], spin[4], rolls[4], place[4], load[4];
	struct scm_soil soils[DEFORM_SOILS];
};
/* Rows of a window, DEFORM_ROWS_ABREAST invocations side by side. */
#define DEFORM_ROWS_ABREAST 4
struct gpu_rect deform_rows(const int32_t posts[4]);

/* load.c: the size of the object's patch and the height at which the soil carries it, as far as they are not known: into
 * `tries`; *last: the try the press goes by. */
enum deform_find { DEFORM_FIND_PATCH = 1, DEFORM_FIND_LOAD = 2 };
enum status deform_find(struct deform *deform, const struct scm_params *params, uint32_t layer, unsigned what,
			int *last) FURROW_CHECKED;
int deform_find_passes(bool patch, bool load);
void deform_find_plan(const char *effect, struct plan *plan);

/* Forces are whole sixteenths of a pascal times a post's area; moments that times an arm. */
#define DEFORM_UNITS_A_PASCAL 16
/* forces.c: the record that this contact's windows add to. */
enum status deform_forces_record(struct deform *deform, const struct deform_sweep *sweep, bool first_window, double arm,
				 struct gpu_buffer **records, uint32_t *record) FURROW_CHECKED;
void deform_forces_destroy(struct deform *deform);
void deform_forces_plan(const char *effect, struct plan *plan);

/* windows.c: the posts a contact can be above. */
struct post_rect deform_shadow(const struct deform *deform, const struct deform_sweep *sweep);
/* The posts it can change; whether they fit one window. */
struct post_rect deform_reached(const struct deform *deform, const struct deform_sweep *sweep);
bool deform_fits_window(const struct deform *deform, struct post_rect reached);

/* spread.c: from `carried`, which a press wrote (at most 2^23 fixed-point units a post), into `deposits`. */
enum status deform_spread(struct deform *deform, const struct deform_window *window, uint32_t layer) FURROW_CHECKED;

/* soil/slide.c: lays the deposits down, then the model's rule over a window's written posts, `iterations` times. A press
 * has left offsets and heaped soil in planes_of[1], and so does this. */
enum status deform_slide(struct deform *deform, const struct deform_window *window, uint32_t layer) FURROW_CHECKED;
struct slide_place {
	uint32_t layer;
	struct gpu_rect all, written; /* what is worked on; what exchanges soil */
	struct place_flags {
		struct gpu_buffer *words;
		uint32_t first, columns;  /* over a window: of the words, of its blocks */
		int32_t from[2];          /* and its first post, from that of its first block */
		int32_t looked[4];        /* its posts across whose sides all was looked at: first, one behind the last */
		bool loaded;
	} flags;
	/* Over blocks: a square of `side` posts each, so many in a row, of which the block and its rim are right. */
	uint32_t blocks, side, columns;
	uint32_t first;               /* of the list: whose flags come first */
};
enum status deform_slide_run(struct deform *deform, const struct slide_place *place) FURROW_CHECKED;
int64_t deform_slide_rim(const struct deform *deform); /* posts */
/* Posts around one that has changed that may exchange soil otherwise. */
int64_t deform_slide_step(const struct deform *deform);
#define STEEP_RELIEF 500.0 /* metres; in a world of less no two posts are too far apart in height */
/* What follows from the parameters. */
void deform_slide_prepare(struct deform *deform);

/* deform.c: the planes of a rectangle of posts to a place of a layer (of the atlas: planes_of[1]), and from there to
 * tiles. */
void deform_gather(struct deform *deform, struct post_rect read, uint32_t layer, uint32_t x, uint32_t y, bool atlas,
		   unsigned planes, const struct deform_tile *tiles, size_t count);
struct scatter_from {
	struct gpu_texture *planes[PLANES]; /* NULL: stays as it is */
	uint32_t layer, x, y;
};
enum status deform_scatter_from(struct deform *deform, struct post_rect write, const struct scatter_from *from,
				const struct deform_tile *tiles, size_t count) FURROW_CHECKED;

/* schedule/active.c */
enum status deform_awake_create(struct deform *deform) FURROW_CHECKED;
void deform_awake_destroy(struct awake *awake); /* takes NULL */
void deform_awake_plan(const char *effect, struct plan *plan);
/* Where a window's sliding puts its flags; of use until the next is asked for, and lasting if deform_wake_swept follows. */
struct place_flags deform_awake_flags(struct deform *deform, const struct deform_window *window, uint32_t layer);
/* Waits for all flags; then no block is awake. */
enum status deform_awake_forget(struct deform *deform) FURROW_CHECKED;
/* The blocks of an interval that begins: the list stays as it is until deform_awake_visited. */
enum status deform_awake_visit(struct deform *deform, const struct deform_block **blocks, size_t *count) FURROW_CHECKED;
bool deform_awake_is_visited(const struct deform *deform, struct deform_block block);
/* They were worked on; `flags` says what still moves in each. */
enum status deform_awake_visited(struct deform *deform, struct gpu_buffer *flags) FURROW_CHECKED;

/* interval.c */
enum status deform_interval_create(struct deform *deform) FURROW_CHECKED;
/* As deform_warm. */
enum status deform_interval_warm(struct deform *deform, const struct deform_shape *shape, uint32_t loaded_body) FURROW_CHECKED;
void deform_interval_plan(const struct deform_params *params, struct plan *plan);
void deform_interval_destroy(struct deform *deform); /* of one that has none, too */

/* stages.c: the passes over a gathered window. */
enum status deform_run_feel(struct deform *deform, const struct deform_sweep *sweep, const struct deform_window *window, uint32_t layer)
	FURROW_CHECKED;
enum status deform_run_stages(struct deform *deform, const struct deform_sweep *sweep,
			      const struct deform_window *window, uint32_t layer) FURROW_CHECKED;

#endif
