// Places are stored as BIAS + x and BIAS - x, so that 0 tells that there are none, and a maximum gives both ends.

const int BIAS = 1 << 30;
