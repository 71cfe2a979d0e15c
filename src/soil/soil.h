/*
 * soil: what both ways to change the ground share: shapes, poses, and the numbers of soils. deform computes kinematic models on the GPU.
 * Soil that bears is computed on the CPU. Functions here are pure, and any thread may call them. Lengths are in metres, angles in radians,
 * unless a comment says otherwise. A fixed-point unit is 2^-20 m.
 */
#ifndef FURROW_SOIL_H
#define FURROW_SOIL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

/* Their numbers are in the hashes of scenes, so a new shape comes last. */
enum soil_shape_kind { SOIL_WHEEL, SOIL_SPHERE, SOIL_BOX, SOIL_MESH, SOIL_CYLINDER, SOIL_CAPSULE, SOIL_ELLIPSOID, SOIL_SHAPES };

/* Triangles in the object's own axes, metres. Its maker owns it. It must outlive every use. */
struct soil_mesh {
	float (*vertices)[3];
	uint32_t (*triangles)[3]; /* indices into vertices; clockwise or not */
	uint32_t vertex_count, triangle_count;
	double low[3], high[3];   /* bounds of the vertices */
};

/*
 * A tyre's carcass: springs around the rim, by area. It keeps its shape up to a pressure, and gives way beyond it by u: p = pressure + stiffness u. So it
 * is a rigid rim on soft soil, and a flat patch on firm ground. soil_tyre_set finds these numbers.
 */
struct soil_tyre {
	double pressure;   /* Pa */
	double stiffness;  /* Pa/m; 0: the wheel is rigid */
	double growth;     /* Pa/m: like stiffness, and also how the patch grows as the wheel comes down; forces are linearised by it */
	double damping;    /* Pa s/m */
	double deflection; /* m: on rigid level ground under its load. It rolls about the radius less this */
};

struct soil_shape {
	enum soil_shape_kind kind;
	double radius;  /* wheel, sphere, cylinder, capsule: metres */
	double width;   /* wheel: metres along its axis */
	double length;  /* cylinder, capsule: metres along its axis, its own z; of a capsule without its two ends */
	double size[3]; /* box: metres along its own x (forward), y (left), z (up); ellipsoid: its half axes along these */
	int grousers;       /* wheel: grousers, evenly spaced bars across the rim that turn with it; 0: a smooth wheel */
	double grouser_height, grouser_thickness; /* of a grouser, metres: beyond the radius, and along the rim */
	struct soil_tyre tyre; /* wheel */
	/* box, mesh: its surface is a belt that runs around its own y axis, as a wheel's rim does. Below a body that it draws forwards it
	 * runs backwards */
	bool belt;
	const struct soil_mesh *mesh;
};

/* The object's centre and attitude, in radians: yaw about z from east to north, then pitch (nose up), then roll (right side
 * down). A wheel's axis is its own y; it rolls along its own x. Its roll is its camber. Its pitch does not count: it only turns the wheel
 * about its axis. `turn`: how far a wheel has turned forwards about its axis, radians. It decides where the grousers are. Of a body with
 * a belt: how far the belt has run, metres. */
struct soil_pose {
	int64_t x, y, z; /* 2^-20 m from the south-west post; z absolute */
	double yaw, pitch, roll, turn;
};

/* Returns true if a body that goes from one pose to the other does not move. One that rises or falls very far counts as set down anew, too.
 * Then only its end pose acts on the ground. */
bool soil_only_set_down(const struct soil_pose *from, const struct soil_pose *to);
/* Returns the posts that a body may be above while it moves, with one post to spare for rounding. `from`: the same as `to` if it does not
 * move. spacing: m between posts. */
struct post_rect soil_shadow(const struct soil_shape *shape, const struct soil_pose *from, const struct soil_pose *to, double spacing);

/* Returns true for a body whose surface runs over it: a wheel, or a body with a belt. Only such a body has a slip. */
bool soil_shape_runs(const struct soil_shape *shape);
/* Returns the radius about which a wheel rolls freely, m: its own, less the deflection of its tyre. Slip is told by it. */
double soil_shape_rolling(const struct soil_shape *shape);
/* Returns how far the surface of a body ran over it, metres. `turned`: of a wheel radians about its axis, of a belt the metres that
 * it ran. 0: the body has no such surface. */
double soil_shape_ran(const struct soil_shape *shape, double turned);
#define SOIL_LAW 6 /* grows whenever bearing soil gives other bits: a drive that began with another number is not resumed */
#define SOIL_SHAPE_POSTS 672 /* the widest body, in posts */
/* Checks that a shape can be simulated with posts `spacing` metres apart. STATUS_INPUT: it cannot; the message tells the limit. */
enum status soil_shape_check(const struct soil_shape *shape, double spacing) FURROW_CHECKED;
/* What is told of a tyre: N/m, N, Pa, N s/m. */
struct soil_tyre_told {
	double stiffness; /* radial */
	double load;      /* at which it has that stiffness, as chord and as tangent, on rigid level ground */
	double pressure;  /* up to which the carcass keeps its shape. NAN: half of the mean pressure on rigid ground at `load` */
	double damping;   /* radial, at `load`. NAN: none */
};
/* Its patch on rigid level ground. */
struct soil_tyre_patch {
	double deflection, length; /* m */
	double pressure;           /* Pa: the mean */
};
#define SOIL_TYRE_DEFLECTION 0.5 /* of the radius: the most under its load */
#define SOIL_TYRE_PRESSURE 0.9   /* of the mean pressure on rigid ground: the most that `pressure` may be */
/* Makes a wheel's tyre of what is told: shape->tyre. *patch: on rigid level ground under told->load; NULL: not asked. STATUS_INPUT: its deflection
 * is more than SOIL_TYRE_DEFLECTION of its radius, or its pressure is beyond SOIL_TYRE_PRESSURE. what: who it is, for the message. */
enum status soil_tyre_set(const char *what, const struct soil_tyre_told *told, struct soil_shape *shape, struct soil_tyre_patch *patch) FURROW_CHECKED;
/* Returns a distance from the object's centre that holds the whole object in any attitude, metres. */
double soil_shape_bound(const struct soil_shape *shape);
/* Computes the object's own axes in a pose: forward, left and up, unit vectors, with `turn` about its own left. */
void soil_axes(double yaw, double pitch, double roll, double turn, double axes[3][3]);
/* Computes the yaw and the roll, -pi / 2 to pi / 2, of a wheel whose axle points along this unit vector. */
void soil_wheel_attitude(const double axle[3], double *yaw, double *roll);
/* Returns the height of the centre above the object's lowest point in this attitude, metres, positive. */
double soil_shape_reach(const struct soil_shape *shape, double pitch, double roll);

/* The numbers of one soil, SI, angles in radians. The scene checks ranges. NAN: the soil has no such number, and no model may
 * read it. */
struct soil_numbers {
	double bekker_kc, bekker_kphi, bekker_n; /* N/m^(n+1), N/m^(n+2), 1 */
	double cohesion, friction_angle;         /* Pa, rad */
	double janosi_shear;                     /* K, m */
	double elastic_stiffness, damping;       /* Pa/m, Pa s/m */
	double density, unit_weight;             /* kg/m3, bulk; N/m3 where the soil is */
	/* Sumner's model: angles in rad; shares of 1. */
	double theta_in, theta_out, theta_stop, roughness, compression;
	double repose; /* rad: model scm: angle of repose of deposited soil */
	double face_strength; /* N/m3: model scm, of faces: the coefficient of 3D-RFT. NAN: soil_face_strength tells it */
	double face_cohesion; /* Pa: model scm: cohesion that faces feel. NAN: soil_face_cohesion tells it */
	/* Under model scm a soil may be a layer over another one, or over rigid ground: src/soil/law/layers.h. NULL: it is endless. The scene owns it. */
	const struct soil_numbers *over;
	double thickness; /* m, of the layer. Read where `over` is not NULL */
	double compaction; /* 0 .. 1: how dense the soil is before a body passes over it. Read with hardening */
};
#define SOIL_ENDLESS 1000.0         /* m: a layer so thick counts as endless */
#define SOIL_RIGID_STIFFNESS 1e9    /* Pa/m: rigid ground without a layer springs, as it must have some stiffness */
/* Sets a soil to rigid ground, over which a layer may lie. */
void soil_set_rigid(struct soil_numbers *soil);
bool soil_is_rigid(const struct soil_numbers *soil);
/* Returns true for rigid ground, and for hard ground that lies bare: rock, asphalt, concrete, ice. It springs, and yields to nothing. */
bool soil_is_hard(const struct soil_numbers *soil);
/* Gives the soil that a layer is if its thickness is 0 or endless: the one below, or itself without that one. Others stay. */
void soil_end_layer(struct soil_numbers *soil);
#define SOIL_CLASSES 16 /* the most soils in one scene */

/* Numbers of a soil that may differ from post to post. */
#define SOIL_NUMBERS_EACH(NUMBER) \
	NUMBER(SOIL_BEKKER_KC, bekker_kc) \
	NUMBER(SOIL_BEKKER_KPHI, bekker_kphi) \
	NUMBER(SOIL_BEKKER_N, bekker_n) \
	NUMBER(SOIL_COHESION, cohesion) \
	NUMBER(SOIL_FRICTION_ANGLE, friction_angle) \
	NUMBER(SOIL_JANOSI_SHEAR, janosi_shear) \
	NUMBER(SOIL_ELASTIC_STIFFNESS, elastic_stiffness) \
	NUMBER(SOIL_THICKNESS, thickness) \
	NUMBER(SOIL_COMPACTION, compaction)
#define SOIL_NUMBER(number, key) number,
enum soil_number { SOIL_NUMBERS_EACH(SOIL_NUMBER) SOIL_NUMBERS };
#undef SOIL_NUMBER
/* Returns the key of a number in a scene. */
const char *soil_number_key(enum soil_number number);
/* Returns the place of a number in a soil. */
double *soil_number_in(struct soil_numbers *soil, enum soil_number number);
/* How a number is kept at each post: a byte. 0: the number is that of the post's soil; 1 to 255: levels from `low` to `high`, which
 * are equally far apart. SI. */
struct soil_raster {
	enum soil_number number;
	double low, high;
};
#define SOIL_RASTERS 4 /* the bytes of a post */
#define SOIL_LEVELS 255
/* Returns the number of a level. `level`: not 0. */
double soil_raster_value(const struct soil_raster *raster, uint8_t level);

/* All predefined soils of Wong's table have these, as no source gives them by soil. */
#define SOIL_USUAL_STIFFNESS 4e7 /* Pa/m */
#define SOIL_USUAL_DAMPING 3e4   /* Pa s/m */
#define SOIL_USUAL_DENSITY 1600.0 /* kg/m3: an estimate, of a soil that has neither density nor unit_weight */
/* Sets every number to NAN. */
void soil_clear(struct soil_numbers *soil);
/* Returns the name of a predefined soil by its index, 0, 1, ...; NULL beyond the last. */
const char *soil_name(size_t index);
/* Fills the numbers of a predefined soil, from Wong's table, Sumner's table, or both. STATUS_INPUT: no soil has this name; the
 * message lists all names. */
enum status soil_named(const char *name, struct soil_numbers *soil) FURROW_CHECKED;

/* Returns the coefficient xi_n of 3D-RFT, N/m3: the soil's face_strength, or unit_weight (894 m^3 - 386 m^2 + 89 m). m is the tangent of the friction
 * angle. The fit is of 0.3 to 0.9; beyond that the nearer end counts. NAN: the soil has no unit_weight. Source: S. Agarwal, D. I. Goldman and K. Kamrin,
 * PNAS 120 (2023), supplement, of soil without cohesion. */
double soil_face_strength(const struct soil_numbers *soil);
/* Returns the cohesion that faces feel, Pa: the soil's face_cohesion. Without one it is the cohesion: none of it below 1.3 kPa, all from 1.7 kPa on. Tables of
 * soils give sand some, from tests at high pressures. But a cut in dry sand falls. */
double soil_face_cohesion(const struct soil_numbers *soil);

/* Shear along an object's surface. Where that is weaker than the soil, the soil slides along it. */
struct soil_interface {
	bool has_friction, has_adhesion; /* false: in its place counts the soil's own friction_angle, soil_own_adhesion */
	double friction_angle, adhesion; /* rad, Pa */
};
/* Returns how strongly soil of this cohesion sticks to a surface of which no adhesion is given, Pa. It has all of the cohesion up to 24 kPa.
 * SOIL.md has the source. */
double soil_own_adhesion(double cohesion);
/* Returns the share of a surface, 0 .. 1, on which cohesion and adhesion hold under a normal stress, Pa: stress / cohesion, at most 1. */
double soil_touching_share(const struct soil_numbers *soil, double stress);

/* Returns the share of its way, 0 to 1, that a body slides on level ground. way: how it goes in its own axes, forward and left, of length 1. runs: how far its rim or belt
 * runs meanwhile; 0: it does not run. *faces: the share that 3D-RFT has below it; Bekker and Janosi have the rest. Pure. */
double soil_slid(const struct soil_shape *shape, const double way[2], double runs, double *faces);

/* m: a body that slips less in a contact digs nothing. Poses are whole fixed-point units of 2^-20 m, so a wheel that rolls without slip seems to
 * slip by some of them. Then a drive in which nothing slips digs nothing, whether or not it keeps what was dug. */
#define SOIL_SLIP_LEAST 0x1p-18

/* Returns the largest shear force on an area, N: of the soil, or along the object's surface if that is less. `area`: m2; `normal`:
 * force across it, N. */
double soil_shear_limit(const struct soil_numbers *soil, const struct soil_interface *interface, double area, double normal);

/* Returns about how deep the object sinks under a load, m, as the start of a search. A wheel: Bekker's formula for a towed
 * wheel. Other shapes: as plates. */
double soil_sinkage_guess(const struct soil_shape *shape, const struct soil_numbers *soil, double load);
/* Returns how much stiffer than its elastic_stiffness a soil springs below a body at a sinkage, m: a layer over stiffer ground does. 1: it is no layer. */
double soil_stiffens(const struct soil_shape *shape, const struct soil_numbers *soil, double sinkage);
/* Returns about what load sinks a wheel that rolls with this slip, or an upright box, by so much, N. `sinkage`: m, above 0. INFINITY:
 * another shape, of which it is not known. */
double soil_load_at(const struct soil_shape *shape, const struct soil_interface *interface, double slip, const struct soil_numbers *soil,
		    double sinkage);

/*
 * --- bearing soil, on the CPU ---
 *
 * Soil that bears bodies: Bekker's pressure, Janosi's shear, elastic rebound. docs/SOIL.md has the law. One implementation computes contacts,
 * equilibrium heights, forces and probes, over planes of posts in host memory. It knows no pages and no tiles.
 */

/* Planes of a rectangle of posts, row by row from the south-west. A plane that nothing needs is NULL. */
struct soil_planes {
	struct post_rect rect;   /* posts of the working level */
	size_t width;            /* posts in a row */
	int32_t *base;           /* 2^-18 m above the store's reference; BASE_NODATA: a hole */
	int32_t *offset, *deposited, *sinkage, *shear, *dug, *settled, *loose, *floor, *density, *slope; /* as the planes of base/plane.h */
	uint8_t *disturbance;
	uint8_t *classes;        /* NULL: one soil */
	uint8_t *levels;         /* SOIL_RASTERS for each post; NULL: no raster */
	uint8_t *contact;        /* what a contact did to each post: SOIL_LOWERED, SOIL_HELD */
};

/* Bits of a post's contact. A post that is neither lowered nor held can take soil. SOIL_CLOSED: over active blocks: the post does not slide, since
 * its block is not active. */
enum { SOIL_LOWERED = 1, SOIL_HELD = 2, SOIL_CLOSED = 8, SOIL_NEAR = 16, SOIL_NO_GROUND = 32 };

#define SOIL_BAND_POSTS 95 /* the widest band of laid soil */

/* What is the same for all contacts of a world. */
struct soil_law {
	double spacing;          /* m between posts */
	int32_t reference;       /* m: heights of bases are above it */
	struct soil_numbers soils[SOIL_CLASSES];
	int soil_count;
	struct soil_raster rasters[SOIL_RASTERS];
	int raster_count;
	bool layered;            /* a soil may lie over another one: soil_law_set_layers sets it */
	double bulldozing;       /* share of the plastic flow that is laid around a body, 0 .. 1 */
	double slip_sinkage;     /* how deep slip digs, in units of the soil's shear modulus; 0: not */
	double loosening;        /* the share by which deposited soil bears less than soil as it lay; 0: it is as stiff as what it lies on */
	double hardening;        /* the share by which passes make soil stronger in the end; 0: not */
	bool ground_normals;     /* stresses act along the normal of the ground; false: along that of the body's lower envelope */
	bool faces;              /* soil pushes on a body's faces from every side as it slides; false: on its lower envelope alone */
	double inertia;          /* of soil that faces push away: lambda of dynamic RFT, 0: none */
};

/* Ends layers that are 0 or endless everywhere, and sets law->layered. Call it when the soils and rasters are set. */
void soil_law_set_layers(struct soil_law *law);
/* Returns the soil of a post of the planes, by its class and what rasters say of it. at: the post's place in the planes. */
struct soil_numbers soil_numbers_at(const struct soil_law *law, const struct soil_planes *planes, size_t at);

/* The recent motion of a body: its motions, each divided by its way, as a mean in which older ones fade out. So after a long straight way it is the motion for each
 * metre of that way. A body that was set down has none. Axes: east, north, up. */
struct soil_recent_motion {
	double way[3];           /* of the centre, m for each m */
	double turn[3];          /* rad for each m; a wheel's turning included */
	double ran;              /* of a belt, m for each m */
};
#define SOIL_TREND_NUMBERS 15
/* whole: its length is the soil's shear modulus; last: it is a thirtieth of that, which tells at once where a body turns back. scooped: volume of soil that a
 * wheel's grousers have taken away below it, for each square metre, m; 0 once it is in the air. */
struct soil_trend {
	struct soil_recent_motion whole, last;
	double scooped;
};
/* Copies a trend to and from plain numbers, for a record. */
void soil_trend_save(const struct soil_trend *trend, double numbers[SOIL_TREND_NUMBERS]);
void soil_trend_load(const double numbers[SOIL_TREND_NUMBERS], struct soil_trend *trend);

/* How a body moved since its last contact: straight, with the attitude of `to`. And how it moves now. Without a last contact from is to. */
struct soil_motion {
	const struct soil_shape *shape;
	struct soil_interface interface;
	struct soil_pose from, to;
	double beyond[3];        /* m from `to`, which is rounded, to the very place */
	double turned;           /* wheel: rad about its axis since `from`; a body with a belt: m that it ran since then */
	double rotated[3];       /* rad about local axes since `from`, of a body that a host moves and that is no wheel */
	double linear[3], angular[3]; /* m/s, rad/s, local axes: what damps; 0 for a body on a path */
	double runs;             /* m/s of its belt */
	double seconds;          /* of a body on a path: how long the motion took, for the soil's inertia; 0: not known */
	struct soil_trend trend; /* its recent motion, up to `from` */
	double load;             /* N, downwards. 0: the height is to.z. Otherwise the equilibrium height is searched */
	double hollows;          /* m: of a body that pushes: posts that it is above by at most this much are below it, too */
	double stamped;          /* hosted: 1: the hollow below `from` has the shape of the body; 0: it is a flat rut */
	bool hosted;             /* a host moves the body, so the motion may be much shorter than a post */
	bool jumped;             /* it did not move from `from` to `to`: it was set down */
};

/* Returns the recent motion of a body after a motion; none where faces do not push. However many pieces a straight motion is cut into, it is the same to rounding. Pure. */
struct soil_trend soil_trend_after(const struct soil_law *law, const struct soil_motion *motion);

#define SOIL_FACES_KNOW 1  /* posts around those below a body of which its faces read what slip dug */
/* Returns how many posts around the shadow of a body its faces read. 0: none of them pushes in this motion. Pure. */
int64_t soil_faces_reach(const struct soil_law *law, const struct soil_motion *motion);

/* How the soil bears a body. */
enum soil_state {
	SOIL_TOUCHING,
	SOIL_SLIDES, /* without its guide it would slide: W sin a > c A + W cos a tan phi, of the soil or of the body's surface */
	SOIL_SUNK,   /* the soil does not carry it: it sank as deep as it is high (a mesh: as its size) */
	SOIL_AIR,    /* no post bears it */
	SOIL_STATES
};

/* The forces of the soil on a body. */
struct soil_forces {
	double force[3];      /* N: east, north, up */
	double moment[3];     /* N m about its centre */
	double sinkage;       /* m: its greatest depth below the base, where the soil bears it; 0 if it is above the base */
	double area;          /* m2: of the ground that carries it */
	double pull;          /* N: what pulls its belt over it, along the belt; below 0 the belt brakes. 0: it has no belt */
	int64_t z;            /* 2^-20 m: height of its centre; with a load, the equilibrium height */
	uint32_t saturated;   /* posts whose share was too large to count, and was cut */
	enum soil_state state;
};

/* Scratch memory of one thread. destroy takes NULL. */
struct soil_work;
enum status soil_work_create(struct soil_work **out) FURROW_CHECKED;
void soil_work_destroy(struct soil_work *work);
size_t soil_work_bytes(const struct soil_work *work); /* all of it, so far */

/*
 * Sliding (SOIL.md): soil slides between two posts if they differ in height by more than their soil's critical difference. All numbers are
 * whole, so the CPU and the GPU compute the same bits. The rule is prepared once. Then any thread may use it.
 */
#define SOIL_BLOCK 32          /* posts along a side of a block */
#define SOIL_SLOPE_HEIGHTS 108 /* heights of slopes for which limits are known; a multiple of 4 */
#define SOIL_SLOPE_HOPS 4      /* of 8, 4, 2 and 1 posts */
#define SOIL_STEEP_RELIEF 500.0 /* metres; with less relief no two posts are too far apart in height for 32 bits */

/* The limits by which a class of soil slides, fixed-point units. Index 0: neighbours along x or y. Index 1: diagonal neighbours. */
struct soil_sliding_class {
	int32_t critical[2]; /* the largest difference of heights that is stable; INT32_MAX: any is */
	/* Only if the height of a slope counts. slope: cotangents of the steepest angles, for rising heights of slopes. rise: two posts belong
	 * to the same slope if they differ by more. */
	int32_t slope[SOIL_SLOPE_HEIGHTS], rise[2];
};

struct soil_shed; /* src/soil/kinematic/shed.h */

struct soil_sliding {
	struct soil_sliding_class classes[SOIL_CLASSES];
	int class_count;         /* a post's class is below it */
	int iterations;          /* 1 .. 8 */
	int directions;          /* of the lines along which soil slides in a contact: 4, 2, or 0 */
	int32_t tolerance;       /* a difference may exceed the critical one by so much without sliding, fixed-point units */
	bool bounded;            /* relaxing soil has a bottom: `depth` below the base, fixed-point units */
	int32_t depth;
	bool undisturbed_stable; /* soil slides only where a difference exceeds that of the bases, too */
	bool steep;              /* neighbours may be too far apart in height for 32 bits */
	int32_t least[2];        /* no difference up to this slides, if the height of slopes does not count */
	int reach;               /* posts over which an interval follows a slope; 0: the height of slopes does not count */
	int32_t slope_least;     /* least axial critical difference in a slope */
	int32_t apart;           /* distance of posts, 2^-20 m, with as many binary digits as the cotangents */
	/* Sumner's rule, by which posts shed soil, in place of the excess over critical differences; NULL: not. It must outlive this. */
	const struct soil_shed *shed;
	int step;                /* an iteration at a post depends on so many posts around it */
};

struct soil_sliding_params {
	const struct soil_numbers *soils;
	int soil_count;            /* 1 .. SOIL_CLASSES */
	double spacing;            /* m */
	/* The model's critical difference of two posts, fixed-point units. apart: their distance, m. NULL: another rule counts, and only the
	 * tolerance is prepared. */
	int32_t (*critical)(const struct soil_numbers *soil, double apart);
	/* The model's cotangent of the steepest stable angle of a slope. height: of the slope, m. NULL: the angle does not depend on it. */
	double (*cotangent)(const struct soil_numbers *soil, double height);
	int iterations;            /* 1 .. 8 */
	int directions;            /* as in struct soil_sliding */
	double depth;              /* m of soil below the base that can relax; INFINITY: no bottom */
	double tolerance;          /* m, 0 .. 1 */
	double relief;             /* m between the world's lowest and highest post; INFINITY: not known */
	bool undisturbed_stable;
	const struct soil_shed *shed; /* as in struct soil_sliding */
};
/* Prepares the rule. */
void soil_sliding_prepare(const struct soil_sliding_params *params, struct soil_sliding *rule);
/* Returns a critical difference with the tolerance. INT32_MAX stays. */
int32_t soil_sliding_with_tolerance(const struct soil_sliding *rule, int32_t critical);
/* Returns sqrt(2) times a difference, to a ten thousandth. */
int32_t soil_sliding_diagonal(int32_t axial);
/* Returns the length of a hop by which a slope is followed, in posts. number: 0 .. SOIL_SLOPE_HOPS - 1. */
static inline int soil_sliding_way(int number)
{
	return 1 << (SOIL_SLOPE_HOPS - 1 - number);
}
/* Returns how many posts around a block an interval reads; at most a block. */
int64_t soil_sliding_rim(const struct soil_sliding *rule);
/* Returns the direction of a pass along lines over a window that writes these posts: 0: x, 1: y, 2: north-east, 3: south-east. pass: from 0 on. */
int soil_sliding_direction(struct post_rect written, int pass);
/* Returns bytes of scratch memory that are enough to slide in planes of this rectangle and with these planes. */
size_t soil_sliding_scratch(const struct soil_sliding *rule, const struct soil_planes *planes);

/* What is told of laid soil that had no room. */
struct soil_slid {
	uint64_t compacted; /* fixed-point units, summed over posts */
	uint64_t refused;   /* posts */
};

struct soil_slide_window {
	struct post_rect written;  /* posts that the window writes */
	struct post_rect posts;    /* of these, where soil may slide: soil_slide_posts */
	struct post_rect world;    /* all posts of the world */
	const int32_t *deposits;   /* laid soil of each post of the planes, fixed-point units, unsigned; NULL: none */
	bool loaded;               /* a body rests by its load, so what it holds may be freed */
};
/* Returns where soil may slide after a contact: the posts that it reached, and `around` posts on each side. reached: a rectangle of all posts
 * that the contact lowered or held, laid soil on, or left. If it is empty, there are no posts. */
struct post_rect soil_slide_posts(struct post_rect written, struct post_rect reached, int64_t around);
/* Returns the columns and rows of the blocks on which posts lie. */
struct post_rect soil_slide_blocks(struct post_rect posts);

/*
 * A set of blocks. One thread at a time uses a set. A set starts as {0}, and grows until it is finished. A failure leaves it as it was.
 */
struct soil_block {
	int64_t x, y; /* posts / SOIL_BLOCK */
};
struct soil_block_set {
	struct soil_block *blocks; /* `count` blocks, in the order in which they were added, or sorted */
	uint32_t *places;          /* 1 + the index in blocks; 0: none */
	size_t count, room;        /* room: of places, a power of two or 0; blocks have half of it */
};
void soil_block_set_finish(struct soil_block_set *set);
enum status soil_block_set_add(struct soil_block_set *set, struct soil_block block) FURROW_CHECKED;
bool soil_block_set_has(const struct soil_block_set *set, struct soil_block block);
/* Returns the block's index in `blocks`; `count` if it is not in the set. */
size_t soil_block_set_place(const struct soil_block_set *set, struct soil_block block);
/* Removes all blocks from the set and keeps its memory. */
void soil_block_set_clear(struct soil_block_set *set);
/* Sorts the blocks along a Morton curve. Then all blocks of one tile are neighbours in the list, for any size of tiles. No block
 * may have a negative x or y. */
void soil_block_set_sort(struct soil_block_set *set);
/* Sorts a list of blocks in the same way, and drops those that stand in it twice. Returns how many are left. Pure. */
size_t soil_blocks_sort(struct soil_block *blocks, size_t count);

/*
 * Active blocks: those in which an interval may change something. After an interval they are the blocks that its words name. What a contact or a
 * host changed since adds others. world: all posts of the world; blocks beyond it are not added.
 */
enum status soil_active_add(struct soil_block_set *set, struct post_rect world, struct soil_block block) FURROW_CHECKED;
/* Returns the posts of all blocks that an interval may change if these posts changed. rim: soil_sliding_rim. */
struct post_rect soil_active_near(struct post_rect world, int64_t rim, struct post_rect changed);
/* Adds these blocks. */
enum status soil_active_add_near(struct soil_block_set *set, struct post_rect world, int64_t rim, struct post_rect changed) FURROW_CHECKED;
/* Adds the blocks that a word of flags keeps active. Bit 0 is the block itself. Bits 1 to 8 are its neighbours W, E, S, N, SW, SE, NW, NE.
 * Words of soil_slide_window and soil_slide_region are so. From bit 16 on they also have the squares of 8 x 8 posts that changed, from the
 * south-west. */
enum status soil_active_add_word(struct soil_block_set *set, struct post_rect world, struct soil_block block, uint32_t word) FURROW_CHECKED;
/* The same of all words of a rectangle of blocks. */
enum status soil_active_add_words(struct soil_block_set *set, struct post_rect world, struct post_rect blocks, const uint32_t *words) FURROW_CHECKED;
/* Marks posts in the planes' contact as closed whose blocks are not in the set. */
void soil_active_close(const struct soil_block_set *set, const struct soil_planes *planes);
/*
 * Adds laid soil to offset and deposited, and slides after a contact. Posts that a body holds give and take nothing. `planes` has the window's
 * read posts. If `rule->steep`, it has one post around `posts`, unless the world ends there. scratch: soil_sliding_scratch bytes. words: one
 * for each block of soil_slide_blocks(written), row by row: what soil_active_add_words takes. Adds to *slid.
 */
void soil_slide_window(const struct soil_sliding *rule, const struct soil_planes *planes, const struct soil_slide_window *window, void *scratch,
		       uint32_t *words, struct soil_slid *slid);
/*
 * Slides for an interval in a region: a rectangle of blocks, as columns and rows. `planes` has their posts and soil_sliding_rim more on each side,
 * with BASE_NODATA beyond the world. Only posts of the blocks are written. Regions of one interval read each other's posts as they were before it,
 * so each has planes of its own. contact tells held posts, and closed ones in blocks that are not active; NULL: none. words: as above, for the
 * region's blocks.
 */
void soil_slide_region(const struct soil_sliding *rule, const struct soil_planes *planes, struct post_rect blocks, void *scratch, uint32_t *words);

/* What a probe tells: how the soil bears a body in a pose, and how that changes with its pose and its velocity. */
struct soil_probed {
	bool known;                   /* false: the planes have not all posts below the body with their neighbours. Then nothing else is set */
	double force[3], moment[3];   /* N, and N m about the body's centre; east, north, up */
	double stiffness[6][6];       /* d(force, moment) / d(translation, rotation about east, north, up): N/m, N, N, N m/rad */
	double damping[6][6];         /* the same of their rates */
	double normal[3];             /* mean normal of the base where the body bears; NAN without contact */
	double pull;                  /* N: as in struct soil_forces */
	double normal_force;          /* N: the normal stress times the body's surface, summed */
	double shear_limit;           /* N: the most that shear can hold, summed in the same way */
	double sinkage, area;         /* as in struct soil_forces */
	enum soil_state state;        /* SOIL_SLIDES: shear is at its limit. SOIL_SUNK: deeper than the body is high */
};

/* Computes the force of the soil on a body at motion->to, without its load: to the bit as soil_sink_body would tell it. Changes nothing. Any
 * thread; `work` belongs to one. STATUS_MEMORY. */
enum status soil_probe(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, struct soil_work *work,
		       struct soil_probed *out) FURROW_CHECKED;
/* The same where other bodies may be over the same ground: soil_sink_begin (soil/sink.h) was called for each. */
enum status soil_probe_among(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion,
			     const struct soil_work *const *others, size_t count, struct soil_work *work, struct soil_probed *out) FURROW_CHECKED;

#include "soil/carried.h"

#endif
