/* SPDX-License-Identifier: MIT */
int lx_unit(int n);
int lx_command(int n);
int lx_nobody(int n);

int lx_unit(int n)
{
    return n + 1;
}

int lx_command(int n)
{
    return n + 2;
}

int lx_nobody(int n)
{
    return n + 3;
}
