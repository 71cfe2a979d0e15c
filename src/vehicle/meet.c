/* Where vehicles touch each other. */
#include <math.h>

#include "vehicle/between.h"
#include "vehicle/start.h"

#define INSIDE 1e-3 /* m: deeper than this, a vehicle starts inside another one */

/* Finds a ball around the parts of a vehicle. */
static void find_ball(const struct vehicles *vehicles, size_t v)
{
	const struct between *between = vehicles->between;
	const struct vehicle *vehicle = &vehicles->list[v];
	struct mover *mover = &between->movers[v];
	mju_copy3(mover->middle, &vehicle->data->xpos[3 * vehicle->root]);
	mover->radius = 0;
	for (size_t i = between->first[v]; i < between->first[v + 1]; i++) {
		const int geom = between->parts[i].geom;
		const double away = mju_dist3(mover->middle, &vehicle->data->geom_xpos[3 * geom]);
		mover->radius = fmax(mover->radius, away + vehicle->model->geom_rbound[geom] + vehicle->model->geom_margin[geom]);
	}
}

static bool are_near(const struct vehicles *vehicles, size_t a, size_t b, const double shift[3])
{
	const struct mover *movers = vehicles->between->movers;
	double way[3];
	mju_sub3(way, movers[b].middle, movers[a].middle);
	mju_addTo3(way, shift);
	return mju_norm3(way) <= movers[a].radius + movers[b].radius;
}

/* Puts the parts of a vehicle to where they are, `shift` away. */
static void place_parts(const struct vehicles *vehicles, size_t v, const double shift[3])
{
	const struct between *between = vehicles->between;
	const struct vehicle *vehicle = &vehicles->list[v];
	for (size_t i = between->first[v]; i < between->first[v + 1]; i++) {
		/* MuJoCo moves the corners of a mesh to axes of their own. */
		const int geom = between->parts[i].geom, here = between->parts[i].here;
		const double *mat = &vehicle->data->geom_xmat[9 * geom];
		double *to = &between->data->geom_xpos[3 * here], own[9];
		mju_mulMatVec3(to, mat, &between->model->geom_pos[3 * here]);
		mju_addTo3(to, &vehicle->data->geom_xpos[3 * geom]);
		mju_addTo3(to, shift);
		mju_quat2Mat(own, &between->model->geom_quat[4 * here]);
		mju_mulMatMat(&between->data->geom_xmat[9 * here], mat, own, 3, 3, 3);
	}
}

/* Mixes what two geoms say of a contact, as MuJoCo does. Torsion and rolling of contacts are left out. */
static void mix(const mjModel *const models[2], const int geoms[2], struct meeting *meeting)
{
	const int priority[2] = {models[0]->geom_priority[geoms[0]], models[1]->geom_priority[geoms[1]]};
	const double weight[2] = {models[0]->geom_solmix[geoms[0]], models[1]->geom_solmix[geoms[1]]};
	const double *reference[2], *impedance[2];
	double share = weight[0] + weight[1] >= mjMINVAL ? weight[0] / (weight[0] + weight[1]) : 0.5, friction[2];
	int dim[2];
	for (int k = 0; k < 2; k++) {
		reference[k] = &models[k]->geom_solref[mjNREF * geoms[k]];
		impedance[k] = &models[k]->geom_solimp[mjNIMP * geoms[k]];
		friction[k] = models[k]->geom_friction[3 * geoms[k]];
		dim[k] = models[k]->geom_condim[geoms[k]];
	}
	const bool direct = priority[0] == priority[1] && !(reference[0][0] > 0 && reference[1][0] > 0);
	if (priority[0] != priority[1]) {
		const int first = priority[0] > priority[1] ? 0 : 1;
		share = 1 - first;
		friction[1 - first] = 0;
		dim[1 - first] = 0;
	}
	for (int i = 0; i < mjNREF; i++)
		meeting->reference[i] = direct ? fmin(reference[0][i], reference[1][i]) : share * reference[0][i] + (1 - share) * reference[1][i];
	for (int i = 0; i < mjNIMP; i++)
		meeting->impedance[i] = share * impedance[0][i] + (1 - share) * impedance[1][i];
	meeting->friction = dim[0] > 1 || dim[1] > 1 ? fmax(friction[0], friction[1]) : 0;
}

static void set_axes(struct meeting *meeting, const double normal[3])
{
	double beside[3] = {0, 0, 0};
	beside[fabs(normal[0]) < 0.6 ? 0 : 1] = 1;
	mju_copy3(meeting->axes[0], normal);
	mju_cross(meeting->axes[1], normal, beside);
	mju_normalize3(meeting->axes[1]);
	mju_cross(meeting->axes[2], normal, meeting->axes[1]);
}

/* Finds where two parts are nearer than a margin. Returns the number of places. */
static int find_touches(const struct between *between, const int types[2], const int here[2], double margin, struct touch touches[mjMAXCONPAIR])
{
	const mjModel *model = between->model;
	mjData *data = between->data;
	mjPreContact found[mjMAXCONPAIR];
	if (types[0] == mjGEOM_BOX && types[1] == mjGEOM_BOX)
		return vehicle_boxes_touch((const double *const[]){data->geom_xpos + 3 * here[0], data->geom_xpos + 3 * here[1]},
				     (const double *const[]){data->geom_xmat + 9 * here[0], data->geom_xmat + 9 * here[1]},
				     (const double *const[]){model->geom_size + 3 * here[0], model->geom_size + 3 * here[1]}, margin, touches);
	const int first = types[0] <= types[1] ? 0 : 1; /* MuJoCo wants the lesser type first */
	mjfCollision collide = mjCOLLISIONFUNC[types[first]][types[1 - first]];
	const int count = collide != NULL ? collide(model, data, found, here[first], here[1 - first], margin) : 0;
	for (int i = 0; i < count; i++) {
		touches[i].gap = found[i].dist;
		mju_copy3(touches[i].place, found[i].pos);
		mju_scl3(touches[i].normal, found[i].normal, first == 0 ? 1 : -1);
	}
	return count;
}

/* Notes where two parts touch. */
static enum status meet(struct vehicles *vehicles, const struct part *const parts[2], const double shift[3])
{
	struct between *between = vehicles->between;
	struct touch touches[mjMAXCONPAIR];
	const mjModel *const models[2] = {vehicles->list[parts[0]->vehicle].model, vehicles->list[parts[1]->vehicle].model};
	const int geoms[2] = {parts[0]->geom, parts[1]->geom}, here[2] = {parts[0]->here, parts[1]->here};
	const int types[2] = {models[0]->geom_type[geoms[0]], models[1]->geom_type[geoms[1]]};
	const double margin = fmax(models[0]->geom_margin[geoms[0]], models[1]->geom_margin[geoms[1]]);
	const double least = fmax(models[0]->geom_gap[geoms[0]], models[1]->geom_gap[geoms[1]]);
	const int count = find_touches(between, types, here, margin, touches);
	for (int i = 0; i < count; i++) {
		if (touches[i].gap >= margin - least)
			continue;
		TRY(mem_grow(&between->meetings, &between->room, between->count + 1, sizeof *between->meetings, "contacts of vehicles"));
		struct meeting *meeting = &between->meetings[between->count++];
		*meeting = (struct meeting){.vehicle = {parts[0]->vehicle, parts[1]->vehicle}, .geom = {geoms[0], geoms[1]},
					    .gap = touches[i].gap - (margin - least), .depth = -touches[i].gap};
		mju_copy3(meeting->point[0], touches[i].place);
		mju_sub3(meeting->point[1], touches[i].place, shift);
		set_axes(meeting, touches[i].normal);
		mix(models, geoms, meeting);
	}
	return STATUS_OK;
}

/* Returns true if two parts may collide and their balls touch. `shift`: from the axes of the second vehicle to those of the first. */
static bool may_meet(const struct vehicles *vehicles, const struct part *a, const struct part *b, const double shift[3])
{
	const struct vehicle *const first = &vehicles->list[a->vehicle], *const second = &vehicles->list[b->vehicle];
	const mjModel *const one = first->model, *const two = second->model;
	if ((one->geom_contype[a->geom] & two->geom_conaffinity[b->geom]) == 0 && (two->geom_contype[b->geom] & one->geom_conaffinity[a->geom]) == 0)
		return false;
	const double reach = one->geom_rbound[a->geom] + two->geom_rbound[b->geom] + fmax(one->geom_margin[a->geom], two->geom_margin[b->geom]);
	double way[3];
	mju_sub3(way, &second->data->geom_xpos[3 * b->geom], &first->data->geom_xpos[3 * a->geom]);
	mju_addTo3(way, shift);
	return mju_norm3(way) <= reach;
}

static enum status find_pair(struct vehicles *vehicles, size_t a, size_t b)
{
	static const double nowhere[3] = {0, 0, 0};
	const struct between *between = vehicles->between;
	double shift[3];
	mju_sub3(shift, vehicles->list[b].origin, vehicles->list[a].origin);
	if (!are_near(vehicles, a, b, shift))
		return STATUS_OK;
	place_parts(vehicles, a, nowhere);
	place_parts(vehicles, b, shift);
	for (size_t i = between->first[a]; i < between->first[a + 1]; i++)
		for (size_t j = between->first[b]; j < between->first[b + 1]; j++)
			if (may_meet(vehicles, &between->parts[i], &between->parts[j], shift))
				TRY(meet(vehicles, (const struct part *const[]){&between->parts[i], &between->parts[j]}, shift));
	return STATUS_OK;
}

struct finding {
	struct vehicles *vehicles;
	enum status status;
};

static enum status find_pairs(struct vehicles *vehicles)
{
	const size_t *order = vehicles->between->order;
	for (size_t v = 0; v < vehicles->count; v++)
		find_ball(vehicles, v);
	for (size_t a = 0; a < vehicles->count; a++)
		for (size_t b = a + 1; b < vehicles->count; b++)
			TRY(find_pair(vehicles, order[a], order[b]));
	return STATUS_OK;
}

static void find_all(void *argument)
{
	struct finding *finding = argument;
	finding->status = find_pairs(finding->vehicles);
}

enum status vehicle_between_find(struct vehicles *vehicles)
{
	struct finding finding = {vehicles, STATUS_OK};
	vehicles->between->count = 0;
	TRY(vehicle_guard("vehicles", find_all, &finding));
	return finding.status;
}

enum status vehicle_between_check_start(struct vehicles *vehicles)
{
	if (vehicles->between == NULL)
		return STATUS_OK;
	TRY(vehicle_between_find(vehicles));
	const struct meeting *deepest = NULL;
	for (size_t i = 0; i < vehicles->between->count; i++)
		if (deepest == NULL || vehicles->between->meetings[i].depth > deepest->depth)
			deepest = &vehicles->between->meetings[i];
	if (deepest == NULL || deepest->depth <= INSIDE)
		return STATUS_OK;
	const struct vehicle *first = &vehicles->list[deepest->vehicle[0]], *second = &vehicles->list[deepest->vehicle[1]];
	char names[2][200];
	vehicle_geom_name(first->model, deepest->geom[0], names[0], sizeof names[0]);
	vehicle_geom_name(second->model, deepest->geom[1], names[1], sizeof names[1]);
	return vehicle_fail_start(vehicles, second, "its geom %s starts %.3g m inside %s of vehicles.%s; move the start of one of them", names[1],
				  deepest->depth, names[0], first->scene->name);
}
