/* What the files of furrow export share. */
#ifndef FURROW_TOOLS_EXPORT_H
#define FURROW_TOOLS_EXPORT_H

#include "chart/chart.h"
#include "command.h"
#include "store/store.h"

/* Those in metres first; of what deformation left: from the offset to the quanta. */
enum export_layer {
	LAYER_SURFACE,
	LAYER_BASE,
	LAYER_OFFSET,
	LAYER_HEAPED,
	LAYER_PRESSED,
	LAYER_SHEAR,
	LAYER_SHEAR_X,
	LAYER_SHEAR_Y,
	LAYER_LOOSE,
	LAYER_DENSITY,
	LAYER_QUANTA,
	LAYER_HILLSHADE,
	LAYER_DISTURBANCE,
	LAYER_BENT,
	LAYER_TORN,
	LAYER_IMAGERY
};

struct export_request {
	const char *command; /* furrow's, for messages */
	const char *path;  /* to write */
	const char *store; /* path, as given */
	int layer;
	struct plane_marks marks; /* the store's time */
	int64_t level;
	bool png, raw, mesh; /* path's ending; mesh: --mesh */
	int up;              /* of a mesh: enum exchange_up */
	bool map;            /* a picture with a frame and a legend */
	bool has_window, has_range;
	double window[4], range[2]; /* window: m from the south-west post; before export_place_window, in window_srs */
	const char *window_srs;     /* NULL: metres from the south-west post; "store": the store's own system */
	struct chart_sun sun;
	double exaggerate;
	/* of a map's page, all zero without it */
	double size;       /* mm */
	uint32_t pixels;   /* of the frame's longer side */
	enum chart_grid grid;
	const char *title;
	bool world_file;   /* of a PNG: says where it lies */
};

/* Reads --layer: a layer by its name, or by its former one. */
enum status export_read_layer(const struct arguments *arguments, int *layer) FURROW_CHECKED;
const char *export_layer_name(int layer);
enum store_layer export_store_layer(int layer);
/* export_window.c: reads --window and --window-srs. */
enum status export_read_window(const struct arguments *arguments, struct export_request *request) FURROW_CHECKED;
/* Makes the window one of metres from the south-west post: of a slanted one, the rectangle around it. */
enum status export_place_window(struct export_request *request, const struct store_meta *meta) FURROW_CHECKED;
bool export_is_ruts(const struct export_request *request); /* the layer is what deformation left */
/* Without a window: of ruts, makes it that of the tiles that changed, and tells it. Not for a raster that is small in whole. */
enum status export_take_changed(struct export_request *request, struct store *store) FURROW_CHECKED;
/* The posts of the level in the window, at least one. STATUS_INPUT: none, or no such level. */
enum status export_find_rect(const struct export_request *request, const struct extent *extent, struct post_rect *rect)
	FURROW_CHECKED;

/* Reads --sun and --exaggerate. `lit`: something is lit; otherwise the options are refused. */
enum status export_read_light(const struct arguments *arguments, struct export_request *request, bool lit) FURROW_CHECKED;

/* export_imagery.c: colours as a PNG. `leveled`: the request says the level. STATUS_INPUT: the store has no imagery. */
enum status export_imagery(const struct export_request *request, bool leveled, struct store *store) FURROW_CHECKED;

/* export_mesh.c: --mesh; the request has its path, level and window. */
enum status export_mesh(const struct export_request *request, struct store *store) FURROW_CHECKED;

/* export_tiles.c: --tiles; and -o OUT.mbtiles. */
enum status export_tiles(const struct arguments *arguments) FURROW_CHECKED;
enum status export_mbtiles(const struct arguments *arguments) FURROW_CHECKED;

/* export_picture.c: a layer in false colour on the hillshade. */
enum status export_check_picture(const struct export_request *request) FURROW_CHECKED;
enum status export_picture(const struct export_request *request, struct store *store) FURROW_CHECKED;

#endif
