/* The cells of soil that a body carries: where they are, what is in them, and what that weighs. */
#include "soil/carried.h"

#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "soil/carried/tops.h"
#include "soil/kinematic/kinematic.h"
#include "soil/shape/body.h"

#define NUMBERS_BEFORE (2 + SOIL_CLASSES)

static int half_of(const struct soil_shape *shape, double spacing)
{
	return (int)ceil(soil_shape_bound(shape) / spacing) + 2;
}

static size_t cells_of(int half)
{
	return (size_t)(2 * half + 1) * (size_t)(2 * half + 1);
}

enum status soil_carried_create(const struct soil_shape *shape, double spacing, struct soil_carried **out)
{
	struct soil_carried *carried;
	enum status status;
	TRY(mem_zeroed(&carried, 1, sizeof *carried, "soil aboard a body"));
	carried->shape = shape;
	carried->spacing = spacing;
	carried->half = half_of(shape, spacing);
	carried->side = 2 * carried->half + 1;
	const size_t cells = cells_of(carried->half);
	TRY_OR(failed, mem_zeroed(&carried->amounts, cells, sizeof *carried->amounts, "soil aboard a body"));
	TRY_OR(failed, mem_zeroed(&carried->falls, cells, sizeof *carried->falls, "soil aboard a body"));
	TRY_OR(failed, mem_make(&carried->tops, cells, sizeof *carried->tops, "soil aboard a body"));
	TRY_OR(failed, mem_make(&carried->before, cells, sizeof *carried->before, "soil aboard a body"));
	TRY_OR(failed, mem_make(&carried->changes, cells, sizeof *carried->changes, "soil aboard a body"));
	TRY_OR(failed, mem_make(&carried->posts, cells, sizeof *carried->posts, "soil aboard a body"));
	struct soil_carried_cells *known = NULL;
	TRY_OR(failed, soil_carried_cells_make(shape, carried->side, &known));
	carried->scratch = known;
	if (shape->kind == SOIL_MESH)
		TRY_OR(failed, soil_kinematic_mirror(shape->mesh, &carried->mirrored));
	for (size_t i = 0; i < cells; i++)
		carried->tops[i] = CARRIED_OPEN;
	*out = carried;
	return STATUS_OK;
failed:
	soil_carried_destroy(carried);
	return status;
}

void soil_carried_destroy(struct soil_carried *carried)
{
	if (carried == NULL)
		return;
	soil_carried_cells_free(carried->scratch);
	mem_free_all(carried->amounts, carried->falls, carried->tops, carried->before, carried->changes, carried->posts, carried->fell, carried->fell_from, carried->caught, carried->mirrored.vertices, carried);
}

enum status soil_carried_let_fly(struct soil_carried *carried)
{
	TRY(mem_zeroed(&carried->fell, cells_of(carried->half), sizeof *carried->fell, "soil that falls off a body"));
	TRY(mem_zeroed(&carried->caught, cells_of(carried->half), sizeof *carried->caught, "soil that falls off a body"));
	return mem_zeroed(&carried->fell_from, cells_of(carried->half), sizeof *carried->fell_from, "soil that falls off a body");
}

void soil_carried_fallen(struct soil_carried *carried, const struct soil_pose *pose, void (*take)(void *user, const int64_t from[3], int32_t amount), void *user)
{
	const double c = cos(pose->yaw + carried->heading), s = sin(pose->yaw + carried->heading);
	for (size_t i = 0; i < cells_of(carried->half) && carried->fell_total > 0; i++) {
		if (carried->fell[i] == 0)
			continue;
		const double along = ((int)(i % (size_t)carried->side) - carried->half) * carried->spacing, across = ((int)(i / (size_t)carried->side) - carried->half) * carried->spacing;
		const int64_t from[3] = {pose->x + lattice_offset(c * along - s * across), pose->y + lattice_offset(s * along + c * across), pose->z + carried->fell_from[i]};
		take(user, from, carried->fell[i]);
		carried->fell_total -= carried->fell[i];
		carried->fell[i] = 0;
	}
	memset(carried->fell_classes, 0, sizeof carried->fell_classes);
}

/* --- where the cells are --- */

/* Finds the neighbour to which the body pushes soil above a cell that it has left. Its edge there came up, and in below that soil. Returns false if there is none. */
static bool find_pushed(const struct soil_carried *carried, size_t cell, size_t *to)
{
	const int side = carried->side, row = (int)(cell / (size_t)side), column = (int)(cell % (size_t)side);
	int32_t most = 0;
	for (int y = row - 1; y <= row + 1; y++)
		for (int x = column - 1; x <= column + 1; x++) {
			if (y < 0 || x < 0 || y >= side || x >= side)
				continue;
			const size_t i = (size_t)(y * side + x);
			if (carried->tops[i] == CARRIED_OPEN || carried->before[i] == CARRIED_OPEN || carried->tops[i] <= carried->before[i] || carried->tops[i] - carried->before[i] <= most ||
			    carried->amounts[i] > CARRIED_MOST - carried->amounts[cell])
				continue;
			most = carried->tops[i] - carried->before[i];
			*to = i;
		}
	return most > 0;
}

/* Soil above cells that the body has left falls, unless the body pushes it inward. So does soil that a part of the body came down on from above. */
static void let_fall(struct soil_carried *carried, double turned)
{
	const double most = 2 * (carried->spacing + soil_shape_bound(carried->shape) * turned);
	const int64_t rise = lattice_offset(fmin(most, 500));
	for (size_t i = 0; i < cells_of(carried->half); i++) {
		const int32_t top = carried->tops[i], before = carried->before[i];
		if (carried->amounts[i] == 0 || (top != CARRIED_OPEN && (before == CARRIED_OPEN || (int64_t)top <= (int64_t)before + carried->amounts[i] + rise)))
			continue;
		size_t to;
		int32_t *const goes = top == CARRIED_OPEN && find_pushed(carried, i, &to) ? &carried->amounts[to] : &carried->falls[i];
		*goes += carried->amounts[i];
		carried->amounts[i] = 0;
	}
}

void soil_carried_place(struct soil_carried *carried, const struct soil_pose *pose)
{
	const double yawed = carried->placed ? remainder(pose->yaw - carried->yaw, 2 * M_PI) : 0;
	const double turned = fabs(remainder(pose->pitch - carried->pitch, 2 * M_PI)) + fabs(remainder(pose->roll - carried->roll, 2 * M_PI));
	const bool was = carried->placed, other = fabs(yawed) > M_PI / 2 && fabs(pose->pitch) > M_PI / 4 && fabs(carried->pitch) > M_PI / 4;
	/* An attitude near the upright has two triples of angles. The cells stay where they are. */
	if (other)
		carried->heading = carried->heading > 0 ? 0 : M_PI;
	carried->yaw = pose->yaw;
	carried->placed = true;
	if (was && !(turned > 0) && !other && pose->turn == carried->turn)
		return;
	carried->pitch = pose->pitch;
	carried->roll = pose->roll;
	carried->turn = pose->turn;
	memcpy(carried->before, carried->tops, cells_of(carried->half) * sizeof *carried->before);
	soil_carried_find_tops(carried, pose);
	if (was && carried->total > 0) {
		let_fall(carried, other ? M_PI : turned);
		carried->unsettled = true;
	}
}

/* Finds the cell nearest to a place, m from the body's centre. Returns false if it has none. */
static bool cell_near(const struct soil_carried *carried, const struct soil_pose *pose, double east, double north, size_t *cell)
{
	const double c = cos(pose->yaw + carried->heading), s = sin(pose->yaw + carried->heading);
	const long column = lround((c * east + s * north) / carried->spacing) + carried->half, row = lround((c * north - s * east) / carried->spacing) + carried->half;
	if (column < 0 || row < 0 || column >= carried->side || row >= carried->side)
		return false;
	*cell = (size_t)row * (size_t)carried->side + (size_t)column;
	return true;
}

/* The same at a post. */
static bool cell_at(const struct soil_carried *carried, const struct soil_pose *pose, int64_t x, int64_t y, size_t *cell)
{
	return cell_near(carried, pose, -(double)soil_body_from_post(pose->x, x, carried->spacing), -(double)soil_body_from_post(pose->y, y, carried->spacing), cell);
}

bool soil_carried_cell(const struct soil_carried *carried, const struct soil_pose *pose, int64_t x, int64_t y, size_t *cell)
{
	return cell_near(carried, pose, lattice_offset_metres(x - pose->x), lattice_offset_metres(y - pose->y), cell);
}

int32_t soil_carried_top_at(const struct soil_carried *carried, const struct soil_pose *pose, int64_t x, int64_t y)
{
	size_t cell;
	return cell_at(carried, pose, x, y, &cell) ? carried->tops[cell] : CARRIED_OPEN;
}

bool soil_carried_catch(struct soil_carried *carried, const struct soil_pose *pose, const int64_t before[3], const int64_t now[3], int64_t volume)
{
	const double east = lattice_offset_metres(now[0] - pose->x), north = lattice_offset_metres(now[1] - pose->y), reach = carried->half * carried->spacing;
	size_t cell;
	if (!(fabs(east) < 2 * reach && fabs(north) < 2 * reach) || !cell_near(carried, pose, east, north, &cell) || carried->tops[cell] == CARRIED_OPEN)
		return false;
	const int64_t height = pose->z + soil_carried_height(carried, cell);
	if (before[2] < height || now[2] > height || volume > CARRIED_MOST - (int64_t)carried->amounts[cell] - carried->caught[cell])
		return false;
	carried->caught[cell] += (int32_t)volume;
	carried->caught_total += volume;
	return true;
}

void soil_carried_keep(struct soil_carried *carried, int class)
{
	if (carried->caught_total == 0)
		return;
	for (size_t i = 0; i < cells_of(carried->half); i++) {
		carried->amounts[i] += carried->caught[i];
		carried->caught[i] = 0;
	}
	carried->total += carried->caught_total;
	carried->classes[class] += carried->caught_total;
	carried->caught_total = 0;
	carried->unsettled = true;
}

int32_t soil_carried_add(struct soil_carried *carried, const struct soil_pose *pose, int64_t x, int64_t y, int32_t amount, int class)
{
	size_t cell;
	if (!cell_at(carried, pose, x, y, &cell) || carried->tops[cell] == CARRIED_OPEN)
		return 0;
	const int32_t room = CARRIED_MOST - carried->amounts[cell], fits = amount < room ? amount : room > 0 ? room : 0;
	carried->amounts[cell] += fits;
	carried->total += fits;
	carried->classes[class >= 0 && class < SOIL_CLASSES ? class : SOIL_CLASSES - 1] += fits;
	if (fits > 0)
		carried->unsettled = true;
	return fits;
}

const uint8_t *soil_carried_shares(const struct soil_carried *carried)
{
	const struct soil_carried_cells *cells = carried->scratch;
	return cells->shares;
}

/* --- what it weighs --- */

void soil_carried_weigh(const struct soil_carried *carried, const double weights[SOIL_CLASSES], double force[3], double moment[3])
{
	const double unit = lattice_offset_metres(1) * carried->spacing * carried->spacing, c = cos(carried->yaw + carried->heading), s = sin(carried->yaw + carried->heading);
	double weight = 0;
	int64_t along = 0, across = 0;
	if (carried->total == 0)
		return;
	for (int k = 0; k < SOIL_CLASSES; k++)
		weight += carried->classes[k] > 0 ? (double)carried->classes[k] * unit * weights[k] : 0;
	for (int row = 0; row < carried->side; row++)
		for (int column = 0; column < carried->side; column++) {
			const size_t i = (size_t)(row * carried->side + column);
			const int64_t amount = (int64_t)carried->amounts[i] + carried->falls[i];
			along += amount * (column - carried->half);
			across += amount * (row - carried->half);
		}
	const double x = (double)along / (double)carried->total * carried->spacing, y = (double)across / (double)carried->total * carried->spacing;
	force[2] -= weight;
	moment[0] -= (s * x + c * y) * weight;
	moment[1] += (c * x - s * y) * weight;
}

/* --- its state --- */

size_t soil_carried_numbers(const struct soil_shape *shape, double spacing)
{
	return NUMBERS_BEFORE + 2 * cells_of(half_of(shape, spacing));
}

void soil_carried_save(const struct soil_carried *carried, int64_t *numbers)
{
	const size_t cells = cells_of(carried->half);
	numbers[0] = carried->heading > 0;
	numbers[1] = carried->unsettled;
	memcpy(numbers + 2, carried->classes, sizeof carried->classes);
	for (size_t i = 0; i < cells; i++) {
		numbers[NUMBERS_BEFORE + i] = carried->amounts[i];
		numbers[NUMBERS_BEFORE + cells + i] = carried->falls[i];
	}
}

bool soil_carried_load(const int64_t *numbers, struct soil_carried *carried)
{
	const size_t cells = cells_of(carried->half);
	int64_t total = 0, classes = 0;
	for (size_t i = 0; i < 2 * cells; i++) {
		const int64_t amount = numbers[NUMBERS_BEFORE + i];
		if (amount < 0 || amount > INT32_MAX)
			return false;
		total += amount;
		*(i < cells ? &carried->amounts[i] : &carried->falls[i - cells]) = (int32_t)amount;
	}
	for (int k = 0; k < SOIL_CLASSES; k++) {
		if (numbers[2 + k] < 0 || numbers[2 + k] > total)
			return false;
		carried->classes[k] = numbers[2 + k];
		classes += numbers[2 + k];
	}
	carried->heading = numbers[0] != 0 ? M_PI : 0;
	carried->unsettled = numbers[1] != 0;
	carried->total = total;
	carried->placed = false;
	return classes == total;
}
