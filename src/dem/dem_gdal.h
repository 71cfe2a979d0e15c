/* Used inside dem only, in a build with GDAL. Opens sources, and resamples them to one lattice of posts in metres. */
#ifndef FURROW_DEM_GDAL_H
#define FURROW_DEM_GDAL_H

#include "dem_gdal_calls.h"
#include "dem_internal.h"
#include "dem_unpack.h"

/* What is told of a source once all are open, once for all sources of which it is told. */
enum source_remark { SOURCE_SYSTEM, SOURCE_UNIT, SOURCE_DEGREES, SOURCE_VERTICAL, SOURCE_DOWN, SOURCE_REMARKS };

/* How a raster has its values, as its vrt tells the pixel function. Before its type Int8, GDAL had bytes with a sign as Byte. */
enum dem_stored { DEM_STORED_PLAIN, DEM_STORED_COLOURS, DEM_STORED_SIGNED_BYTE };

/* One source file. `vrt` is a small virtual raster in GDAL's memory files. It gives band 1 in metres, with NaN for nodata. So
 * its readers need not handle nodata values, scales and units. */
struct gdal_source {
	const char *path;
	const char *name; /* under which GDAL opens it: the path, or that of what it was unpacked to */
	struct dem_unpacked unpacked;
	char *vrt; /* name of the virtual raster; NULL before it is made */
	int band;     /* that has the heights, from 1 */
	bool colours; /* heights are coded in three bands, of which it is the first */
	int threads;  /* of GDAL that decode its blocks */
	int width, height;
	double place[6]; /* GDAL's geotransform, for pixel corners, of a raster along the axes as if it counted from the north and the west */
	bool from_east, from_south; /* the raster counts its columns, or its rows, from there */
	bool placed;
	OGRSpatialReferenceH srs; /* NULL if unknown or local */
	int system;               /* number of the first source that has the same SRS */
	double low[2], high[2];   /* its area in the SRS of the target, x and y */
	bool doubles;             /* heights need 64 bits */
	double unit;              /* as in dem_info */
	char *remarks[SOURCE_REMARKS]; /* NULL: nothing is told */
	int64_t panel_posts;      /* as in dem_info */
	bool whole;               /* heights are exactly whole numbers of units */
	char *own;      /* what its heights are above, as it says (struct dem_vertical); NULL: it does not say */
	char *from, *to; /* heights are converted from one vertical reference to the other; NULL: they are not */
	char vertical[160]; /* describes what heights are above, when they are converted */
	char replaced[80];  /* name of the file's own SRS, if the one given instead is another; "": it is not */
};

#define DEM_CACHE_BYTES (48 << 20) /* bytes of decoded blocks that GDAL keeps */

/* Loads GDAL and registers its drivers, once; any thread. To be called before any function of GDAL. STATUS_FAILED: it cannot
 * be loaded; the message names `what`, the file or name that needs it. */
enum status dem_gdal_init(const char *what) FURROW_CHECKED;
void dem_gdal_register(void);       /* of dem_gdal_init: drivers, the size of the cache, and our pixel function */
/* ": " and the last message of GDAL, "" if there is none; valid until the next call in this thread. */
const char *dem_gdal_because(void);

/* --- dem_network.c: GDAL fetches nothing, unless it was allowed --- */
void dem_network_close_process(void); /* for all threads; of the command */
/* For this thread; of callers of the library. May be nested. GDAL is loaded. */
void dem_network_close_thread(void);
void dem_network_reopen_thread(void);
bool dem_network_is_open(void); /* dem_network_begin was called, and dem_network_end not yet */
/* Returns true for a driver that uses a network, or whose files name others anywhere. */
bool dem_gdal_is_networked(GDALDriverH driver);
/* Returns the names of drivers that open sources, ended by NULL. NULL: all do. */
const char *const *dem_gdal_drivers(void);

/* --- dem_srs_text.c --- */
/* Returns why the text of an SRS is not read: it leads to a file or a network. NULL: it may be. */
const char *dem_srs_text_problem(const char *text);

/* --- dem_source.c --- */
/* Opens a source. Adds to `files` the other files that belong to it. */
enum status dem_source_init(struct gdal_source *source, const struct dem_params *params, const char *path,
			    OGRSpatialReferenceH override, int number, struct dem_list *files) FURROW_CHECKED;
/* Returns false if the file can be opened and has no place. */
bool dem_source_is_placed(const struct dem_params *params, const char *path);
void dem_source_finish(struct gdal_source *source);
/* Keeps what is to be told of the source. Without memory it is not told. */
void dem_source_remark(struct gdal_source *source, enum source_remark which, const char *format, ...) FURROW_PRINTF(3, 4);

/* --- dem_radii.c: values that are radii --- */
struct dem_radius {
	double sphere; /* metres: taken off; 0: values are heights */
	double unit;   /* metres of the source's unit */
};
/* Finds out if a source's values are radii. Its vrt gives them in `unit` metres; `said`: the source says this unit. STATUS_INPUT: they
 * are, or are to be, and its SRS has no sphere. */
enum status dem_radii_find(const struct gdal_source *source, enum dem_radii radii, double unit, bool said, struct dem_radius *out)
	FURROW_CHECKED;

/* --- dem_turn.c --- */
/* Counts the x of sources of one SRS so that sources on both sides of a seam of longitude lie beside each other. Their systems are known. */
enum status dem_turn_join(struct gdal_source *sources, size_t count) FURROW_CHECKED;

/* --- dem_map.c: where the posts of one lattice lie on another --- */
/* Post (column, row) is at x = at[0] + column * at[1] + row * at[2], y = at[3] + column * at[4] + row * at[5]. Rows count to the
 * north, unless the raster is rotated or mirrored. */
struct dem_lattice {
	double at[6];
	int64_t width, height;    /* posts */
	OGRSpatialReferenceH srs; /* not owned; NULL: none */
};
#define DEM_BLOCK_SIDE 512 /* posts: the longest side of a rectangle whose places are mapped in one call */
struct dem_map;
void dem_lattice_point(const struct dem_lattice *lattice, double column, double row, double *x, double *y);
/* Gives the affine transformation from coordinates to columns and rows. Returns false if there is none. */
bool dem_lattice_invert(const struct dem_lattice *lattice, double inverse[6]);
/* Copies `from`; its SRS must outlive the map. `name`: of the source, for messages. One thread at a time uses a map. */
enum status dem_map_create(const struct dem_lattice *from, const struct dem_lattice *to, const char *name, struct dem_map **out)
	FURROW_CHECKED;
void dem_map_destroy(struct dem_map *map); /* map may be NULL */
/* Returns true if posts are posts of the other lattice, as many columns and rows further; tells how many. */
bool dem_map_shift(const struct dem_map *map, double *column, double *row);
/* Gives the columns and rows on the other lattice of the posts in `rect`, row by row; NaN: nowhere. They are off by at most 0.01. */
void dem_map_rect(const struct dem_map *map, struct post_rect rect, double *columns, double *rows);

/* --- dem_layers.c: several sources on one lattice; the first source is on top --- */
struct dem_layers;
/* Returns true if the posts of both sources lie on one lattice. */
bool dem_layers_fit(const struct gdal_source *a, const struct gdal_source *b);
/* The sources must outlive the layers. */
enum status dem_layers_create(const struct gdal_source *const *sources, size_t count, struct dem_layers **out) FURROW_CHECKED;
void dem_layers_destroy(struct dem_layers *layers);                                 /* layers may be NULL */
const struct dem_lattice *dem_layers_lattice(const struct dem_layers *layers); /* of the area that all sources cover together */
/* Reads the posts of `rect`, which lies in the lattice, row by row from the south, metres. *done is false if GDAL could not read
 * them; GDAL's message tells why. */
enum status dem_layers_read(struct dem_layers *layers, struct post_rect rect, double *heights, bool *done)
	FURROW_CHECKED;

/* --- dem_sampler.c: heights of a raster at the posts of another lattice --- */
struct dem_sampler;
struct dem_sampling {
	struct dem_layers *layers;         /* must outlive the sampler */
	const struct dem_lattice *raster;  /* of the layers */
	const struct dem_lattice *posts;   /* where heights are wanted */
	enum dem_resample method;
	double span[2];                    /* as in struct dem_kernel */
	bool single;                       /* heights are rounded to floats, as the raster's are */
	const char *name;                  /* of the source, for messages */
};
/* Posts, and what is known of each: enum dem_sampled. */
struct dem_samples {
	struct post_rect rect;
	double *heights;  /* metres, row by row from the south */
	uint8_t *sampled;
	uint16_t *owners; /* set to `owner` where a height is set; may be NULL */
	uint16_t owner;
};
enum status dem_sampler_create(const struct dem_sampling *sampling, struct dem_sampler **out) FURROW_CHECKED;
void dem_sampler_destroy(struct dem_sampler *sampler);          /* sampler may be NULL */
bool dem_sampler_copies(const struct dem_sampler *sampler); /* returns true if posts are the raster's own, not resampled */
/* Gives the column and row of a post on the raster; NaN: nowhere. */
void dem_sampler_place(const struct dem_sampler *sampler, int64_t x, int64_t y, double *column, double *row);
/* Returns true if all posts of `rect` are the raster's own; gives the rectangle in which they lie there. */
bool dem_sampler_copied(const struct dem_sampler *sampler, struct post_rect rect, struct post_rect *from);
/* Sets those heights in `part` of which this raster knows more than is known already. *done as in dem_layers_read. */
enum status dem_sampler_read(struct dem_sampler *sampler, struct dem_samples *samples, struct post_rect part, bool *done)
	FURROW_CHECKED;

/* --- dem_group.c: sources on one lattice --- */
struct dem_group {
	const struct gdal_source **sources; /* in the order in which they were named */
	size_t count;
	struct dem_layers *layers;
	struct dem_sampler *sampler; /* at the posts of the target; NULL before it is made */
	struct dem_map *back;        /* from the group's posts to the target; NULL before it is made */
	double step[2];              /* metres on the ground between posts, along a row and a column */
	bool projected;              /* the target has another SRS */
};
struct dem_groups {
	struct dem_group *groups; /* an earlier one lies over later ones */
	size_t count;
};
/* The sources must outlive the groups. dem_groups_finish is due also after a failure. */
enum status dem_groups_init(struct dem_groups *groups, const struct gdal_source *sources, size_t count) FURROW_CHECKED;
void dem_groups_finish(struct dem_groups *groups);

/* --- dem_target.c: the lattice of the result --- */
struct dem_target {
	OGRSpatialReferenceH srs; /* NULL: local metres */
	bool keep;                /* the SRS of the first source, true or not */
	double spacing;           /* metres */
	double origin[2];         /* of the south-west post, in `srs` */
	int64_t width, height;    /* posts */
};
/* Chooses the SRS, unless target->srs is set, and the spacing, and sets `step` and `projected` of each group. `target`: all zero, or set by
 * an earlier call. dem_target_finish is due also after a failure. */
enum status dem_target_measure(const struct dem_params *params, struct dem_groups *groups, struct dem_target *target) FURROW_CHECKED;
double dem_target_own_spacing(const struct dem_group *group); /* metres between its posts if nothing else were imported; after dem_target_measure */
struct dem_area {
	double low[2], high[2]; /* x and y in the target's SRS */
};
/* Gives the area of a group's posts. */
enum status dem_target_area(const struct dem_target *target, const struct dem_group *group, struct dem_area *area) FURROW_CHECKED;
/* The same as dem_target_measure, and chooses the posts. */
enum status dem_target_choose(const struct dem_params *params, struct dem_groups *groups, struct dem_target *target) FURROW_CHECKED;
void dem_target_finish(struct dem_target *target);
void dem_target_lattice(const struct dem_target *target, struct dem_lattice *lattice);
/* As `keepable` of dem_info, of groups whose target is chosen. */
bool dem_target_keepable(const struct dem_params *params, const struct dem_groups *groups);
/* As dem_ground_off, of all posts of the target, which has an SRS. */
double dem_target_ground_off(const struct dem_target *target);

/* --- dem_misfit.c --- */
/* Heights at posts of the target, whose surface is bilinear, and the part of it that is measured. */
struct dem_surface {
	struct dem_part part;
	double low[2], high[2]; /* columns and rows from `low` to below `high` are measured */
	const uint16_t *owners; /* for each post, which group it was taken from; NULL: there is one group */
};
/* Posts of a group that are compared at once. */
struct dem_misfit_part {
	size_t group;
	struct post_rect posts;
};
/* Gives the parts that may lie under a surface, to be freed with mem_free. */
enum status dem_misfit_parts(const struct dem_groups *groups, const struct dem_surface *surface, struct dem_misfit_part **parts,
			     size_t *count) FURROW_CHECKED;
struct dem_misfit_room;
struct dem_misfit_room *dem_misfit_room_create(void); /* scratch for a part; to be freed with mem_free. NULL: out of memory */
/* Adds by how much the surface is off posts of a part, where it is made from their group. *done as in dem_layers_read. */
enum status dem_misfit_part(const struct dem_groups *groups, const struct dem_misfit_part *part, const struct dem_surface *surface,
			    struct dem_misfit_room *room, struct misfit *misfit, bool *done) FURROW_CHECKED;

/* --- dem_overlap.c: compares sources where they overlap in the target; also sets `low` and `high` of each source, and the grid's
 * overlap_... --- */
enum status dem_overlap(struct gdal_source *sources, size_t count, const struct dem_lattice *target, struct dem_grid *grid)
	FURROW_CHECKED;

/* --- dem_srs.c --- */
/* Returns a new SRS with x east. Returns NULL and sets the failure message if `text` is not an SRS. */
OGRSpatialReferenceH dem_srs_parse(const char *text);
/* As dem_srs_parse, for what a user gives: it may also be the name of a file that holds the text. */
OGRSpatialReferenceH dem_srs_parse_given(const char *text);
/* Checks the SRS of a raster: STATUS_INPUT if it names a file by a path. */
enum status dem_srs_check(const char *path, OGRSpatialReferenceH srs) FURROW_CHECKED;
/* Longitude and latitude in degrees: WGS 84 on the Earth, on another body its own. NULL: the SRS is local, or GDAL fails. */
OGRSpatialReferenceH dem_srs_degrees(OGRSpatialReferenceH srs);
/* As dem_srs_parse, but DEM_SRS_DEGREES means the degrees of the body of `other`. */
OGRSpatialReferenceH dem_srs_parse_beside(const char *text, OGRSpatialReferenceH other);
/* Makes the transformation. `told` names what is converted, and `whose` the owner of `to`, for messages. STATUS_INPUT: there is no way;
 * between two bodies there is none. */
enum status dem_srs_move(const char *told, OGRSpatialReferenceH from, OGRSpatialReferenceH to, const char *whose, OGRCoordinateTransformationH *move)
	FURROW_CHECKED;
/* Writes the code of an SRS, as EPSG:32611, or its name if it has no code. */
void dem_srs_told(OGRSpatialReferenceH srs, char *text, size_t size);
/* Returns true if the two differ in more than their vertical part. */
bool dem_srs_differ(OGRSpatialReferenceH a, OGRSpatialReferenceH b);
/* Returns the metres on the ground from (x, y) to (x + dx, y + dy). Returns NaN if this cannot be computed. */
double dem_srs_ground(OGRSpatialReferenceH srs, double x, double y, double dx, double dy);
/* As dem_ground_off. */
double dem_srs_ground_off(OGRSpatialReferenceH srs, const double low[2], const double high[2]);
/* Returns a metric SRS for data around (x, y): UTM, or on other planets an equirectangular projection. NULL: failed. */
OGRSpatialReferenceH dem_srs_metric(OGRSpatialReferenceH srs, double x, double y);
/* Returns the SRS as WKT, to free with mem_free; NULL: out of memory. */
char *dem_srs_wkt(OGRSpatialReferenceH srs);
/* The length of one turn around the body along x, in units of `srs`: x and x + turn are one place. 0: x has no such length, or it is not known.
 * *middle: x of the SRS's own central meridian. */
double dem_srs_turn(OGRSpatialReferenceH srs, double *middle);

#endif
