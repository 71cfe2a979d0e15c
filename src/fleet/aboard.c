/*
 * Soil aboard a body, as a part of a message. First comes the body's number, then how many numbers of its soil are not 0, then each of these with its index.
 * Most cells are empty.
 */
#include "fleet/internal.h"

#include <string.h>

struct number {
	uint32_t index;
	int64_t value;
};

static enum status put_numbers(struct fleet_bytes *bytes, const int64_t *numbers, size_t count)
{
	uint32_t has = 0;
	for (size_t i = 0; i < count; i++)
		has += numbers[i] != 0;
	TRY(fleet_put(bytes, &has, sizeof has));
	for (size_t i = 0; i < count; i++) {
		struct number number;
		if (numbers[i] == 0)
			continue;
		memset(&number, 0, sizeof number); /* its padding, too: it is sent as bytes */
		number.index = (uint32_t)i;
		number.value = numbers[i];
		TRY(fleet_put(bytes, &number, sizeof number));
	}
	return STATUS_OK;
}

enum status fleet_aboard_put(struct fleet *fleet, struct fleet_bytes *bytes, size_t body)
{
	const size_t count = world_carried_moves(fleet->world, body);
	const int64_t name = (int64_t)body;
	TRY(mem_grow(&fleet->aboard, &fleet->aboard_room, count, sizeof *fleet->aboard, "soil aboard bodies"));
	world_carried_pack(fleet->world, body, fleet->aboard);
	TRY(fleet_put(bytes, &name, sizeof name));
	return put_numbers(bytes, fleet->aboard, count);
}

static enum status get_numbers(struct fleet_bytes *bytes, int64_t *numbers, size_t count)
{
	uint32_t has;
	TRY(fleet_get(bytes, &has, sizeof has));
	memset(numbers, 0, count * sizeof *numbers);
	for (uint32_t i = 0; i < has; i++) {
		struct number number;
		TRY(fleet_get(bytes, &number, sizeof number));
		if (number.index >= count)
			return fail_with(STATUS_FAILED, "ranks: soil came aboard a body that has no place for it; start all ranks with the same version of furrow");
		numbers[number.index] = number.value;
	}
	return STATUS_OK;
}

enum status fleet_aboard_get(struct fleet *fleet, struct fleet_bytes *bytes, bool takes, bool places)
{
	int64_t body;
	TRY(fleet_get(bytes, &body, sizeof body));
	const size_t count = body >= 0 ? world_carried_moves(fleet->world, (size_t)body) : 0;
	if (count == 0)
		return fail_with(STATUS_FAILED, "ranks: soil came aboard a body that carries none; start all ranks with the same version of furrow");
	TRY(mem_grow(&fleet->aboard, &fleet->aboard_room, count, sizeof *fleet->aboard, "soil aboard bodies"));
	TRY(get_numbers(bytes, fleet->aboard, count));
	return takes ? world_carried_unpack(fleet->world, (size_t)body, fleet->aboard, places) : STATUS_OK;
}

enum status fleet_aboard_put_all(struct fleet *fleet, bool vehicles)
{
	const struct world *world = fleet->world;
	uint32_t count = 0;
	const size_t at = fleet->sent.size;
	TRY(fleet_put(&fleet->sent, &count, sizeof count));
	for (size_t i = 0; i < world_body_count(world); i++) {
		if (!world_ranked(world, i) || world_body(world, i)->elsewhere || world_carried_moves(world, i) == 0 ||
		    (vehicles && world_body(world, i)->kind != BODY_VEHICLE))
			continue;
		TRY(fleet_aboard_put(fleet, &fleet->sent, i));
		count++;
	}
	memcpy(fleet->sent.bytes + at, &count, sizeof count);
	return STATUS_OK;
}

enum status fleet_aboard_get_all(struct fleet *fleet, int rank, struct fleet_bytes *bytes, bool places)
{
	uint32_t count;
	TRY(fleet_get(bytes, &count, sizeof count));
	for (uint32_t i = 0; i < count; i++)
		TRY(fleet_aboard_get(fleet, bytes, rank != fleet->rank, places));
	return STATUS_OK;
}

static enum status get_loads(void *user, int rank, struct fleet_bytes *bytes)
{
	return fleet_aboard_get_all(user, rank, bytes, true);
}

enum status fleet_loads(void *user)
{
	struct fleet *fleet = user;
	struct fleet_told told;
	enum status status = fleet_begin(fleet, FLEET_LOADS, STATUS_OK);
	if (status == STATUS_OK)
		status = fleet_aboard_put_all(fleet, true);
	return fleet_tell(fleet, FLEET_LOADS, status, &told, get_loads, fleet);
}
